// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/arguments.h"

#include <algorithm>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "api/text/numbers.h"
#include "api/text/text.h"
#include "server/flags/flag_values.h"
#include "server/processes/process.h"

namespace ccdt::server {
namespace {

constexpr std::uint64_t kMaxThreads = 1024;
constexpr std::uint64_t kMaxSites = 100'000'000;
constexpr std::uint64_t kMaxPixels = 1'000'000'000;

tl::unexpected<Error> unknown_option(std::span<const Option> options, const std::string& written,
                                     std::string_view name) {
    std::vector<std::string> names;
    for (const Option& option : options) names.push_back("--" + option.name);
    const std::string hint = suggestion(names, "--" + std::string(name));
    return failure(ErrorCode::Malformed, written + " is not an option; " + hint, written);
}

/// An option as it was written.
struct Written {
    const Option* option = nullptr;
    std::string text;                  ///< the argument up to the value
    std::optional<std::string> value;  ///< value in the same argument
    bool is_negated = false;           ///< whether a flag begins with `--no-`
};

Result<Written> read_option(std::span<const Option> options, std::string_view argument) {
    Written written;
    const auto find = [&](std::string_view name) {
        const auto found = std::ranges::find(options, name, &Option::name);
        return found == options.end() ? nullptr : &*found;
    };
    if (!argument.starts_with("--")) {
        written.text = argument.substr(0, 2);
        const auto found = std::ranges::find(options, argument[1], &Option::letter);
        if (found == options.end()) return unknown_option(options, std::string(argument), argument.substr(1));
        written.option = &*found;
        if (argument.size() > 2) written.value = argument.substr(argument[2] == '=' ? 3 : 2);
    } else {
        const auto equals = argument.find('=');
        written.text = argument.substr(0, equals);
        if (equals != std::string_view::npos) written.value = argument.substr(equals + 1);
        const std::string name = hyphenated(std::string_view(written.text).substr(2));
        written.option = find(name);
        if (written.option == nullptr && name.starts_with("no-")) {
            written.option = find(std::string_view(name).substr(3));
            written.is_negated = true;
            if (written.option != nullptr && !written.option->is_flag()) written.option = nullptr;
        }
        if (written.option == nullptr) return unknown_option(options, written.text, name);
    }
    if (written.option->is_flag() && written.value && (written.is_negated || written.option->member.empty()))
        return failure(ErrorCode::Malformed, written.text + " has no value", written.text);
    return written;
}

/// Stores the value of an option of the program.
Result<void> set_option(const Written& written, const std::string& value, Arguments& arguments) {
    const std::string& name = written.option->name;
    const auto store = [&](std::size_t& target, const Result<std::size_t>& parsed) -> Result<void> {
        if (!parsed)
            return failure(ErrorCode::Malformed,
                           written.text + " must be " + parsed.error().message + ", not '" + value + "'", written.text);
        target = *parsed;
        return {};
    };
    if (name == "threads") return store(arguments.threads, parse_whole(value, 1, kMaxThreads));
    if (name == "memory") return store(arguments.memory, parse_bytes(value));
    if (name == "max-sites") return store(arguments.limits.max_sites, parse_whole(value, 1, kMaxSites));
    if (name == "max-pixels") return store(arguments.limits.max_pixels, parse_whole(value, 1, kMaxPixels));
    if (name == "max-faces") return store(arguments.limits.max_faces, parse_whole(value, 1, kMaxFaces));
    if (name == "output") {
        if (value.empty())
            return failure(ErrorCode::Malformed, written.text + " needs the name of a file", written.text);
        arguments.output = value;
        return {};
    }
    bool& flag = name == "quiet" ? arguments.quiet : name == "json" ? arguments.json : arguments.help;
    flag = !written.is_negated;
    return {};
}

/// Replaces a number such as `20k` by one without the letter.
void expand_thousands(std::string& value) {
    if (!value.ends_with('k')) return;
    const auto number = api::parse_number<double>(std::string_view(value).substr(0, value.size() - 1));
    if (!number) return;
    value.clear();
    api::append_fixed(value, 1000 * *number, 6);
}

/// Replaces a domain in the plane that is given as a word, with the options --width and --height, by an object.
void name_sides_of_domain(Arguments& arguments) {
    const auto find = [&](std::string_view name) {
        return std::ranges::find(arguments.given, name, [](const auto& each) { return each.option->name; });
    };
    const auto end = arguments.given.end(), domain = find("domain"), width = find("width"), height = find("height");
    if (domain == end || width == end || height == end || find("depth") != end || !arguments.inputs.empty()) return;
    if (domain->value != "rectangle" && domain->value != "torus") return;
    domain->value =
        R"({"type":")" + domain->value + R"(","width":)" + width->value + R"(,"height":)" + height->value + '}';
    std::erase_if(arguments.given,
                  [](const auto& each) { return each.option->name == "width" || each.option->name == "height"; });
}

}  // namespace

const Arguments::Given* Arguments::find_given(std::string_view name) const {
    const auto found = std::ranges::find_if(given, [&](const Given& each) { return each.option->name == name; });
    return found == given.end() ? nullptr : &*found;
}

const std::string* Arguments::find(std::string_view name) const {
    const Given* const found = find_given(name);
    return found == nullptr ? nullptr : &found->value;
}

Result<Arguments> parse_arguments(std::span<const Option> options, std::span<const char* const> arguments) {
    Arguments result;
    result.threads = std::max<std::size_t>(1, std::thread::hardware_concurrency());
    result.memory = available_memory() / 4 * 3;
    result.limits = {.max_sites = kMaxSites, .max_pixels = kMaxPixels, .max_faces = kMaxFaces};
    std::vector<const Option*> before;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string_view argument = arguments[i];
        if (argument == "--") {
            result.inputs.insert(result.inputs.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                 arguments.end());
            break;
        }
        if (!argument.starts_with('-') || argument == "-") {
            result.inputs.emplace_back(argument);
            continue;
        }
        auto written = read_option(options, argument);
        if (!written) return tl::unexpected(written.error());
        const Option& option = *written->option;
        if (std::ranges::find(before, &option) != before.end())
            return failure(ErrorCode::Malformed, written->text + " is given twice", written->text);
        before.push_back(&option);
        if (option.is_flag()) {
            if (!written->value) written->value = written->is_negated ? "false" : "true";
        } else if (!written->value) {
            if (++i == arguments.size())
                return failure(ErrorCode::Malformed, written->text + " needs a value", written->text);
            written->value = arguments[i];
        }
        if (!option.member.empty()) {
            result.given.push_back({&option, *written->value, *written->value});
            if (option.takes_number) expand_thousands(result.given.back().value);
        } else if (auto set = set_option(*written, *written->value, result); !set) {
            return tl::unexpected(set.error());
        }
    }
    name_sides_of_domain(result);
    return result;
}

}  // namespace ccdt::server

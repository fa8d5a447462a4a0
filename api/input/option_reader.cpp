// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/option_reader.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxMembers = 64;
constexpr std::size_t kMaxExcerpt = 64;

/// Maximum number of errors reported in addition to the first one. Each message may list all possible values.
constexpr std::size_t kMaxOthers = 9;

std::optional<std::uint64_t> integer_of(const Input& input) {
    if (const auto* text = std::get_if<std::string_view>(&input.value)) return parse_number<std::uint64_t>(*text);
    const auto json = std::get<JsonValue>(input.value);
    if (!json.is_number()) return std::nullopt;
    const double number = json.number();
    if (number < 0 || number > static_cast<double>(kMaxInteger) || number != std::floor(number)) return std::nullopt;
    return static_cast<std::uint64_t>(number);
}

std::optional<double> number_of(const Input& input) {
    if (const auto* text = std::get_if<std::string_view>(&input.value)) return parse_number<double>(*text);
    const auto json = std::get<JsonValue>(input.value);
    if (!json.is_number()) return std::nullopt;
    return json.number();
}

std::string shortest(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string describe(const Interval& allowed) {
    const bool bounded = allowed.max < std::numeric_limits<double>::max();
    std::string text = "must be a number ";
    text += (allowed.above_min ? "above " : bounded ? "from " : "of at least ") + shortest(allowed.min);
    if (bounded) text += (allowed.above_min ? ", at most " : " to ") + shortest(allowed.max);
    return text;
}

}  // namespace

tl::unexpected<Error> malformed(const Input& input, std::string_view what) {
    return failure(ErrorCode::Malformed, input.name + ' ' + std::string(what), input.field);
}

tl::unexpected<Error> unknown_option(const Input& input, std::span<const std::string_view> known) {
    std::string message = "unknown option '" + excerpt(input.name) + "'; the options are";
    for (const auto name : known) message.append(name == known.front() ? " " : ", ").append(name);
    return failure(ErrorCode::Malformed, std::move(message), excerpt(input.field));
}

Result<std::uint64_t> read_integer(const Input& input, std::uint64_t min, std::uint64_t max) {
    const auto value = integer_of(input);
    if (value && *value >= min && *value <= max) return *value;
    return malformed(input, "must be an integer from " + std::to_string(min) + " to " + std::to_string(max));
}

Result<double> read_number(const Input& input, const Interval& allowed) {
    const auto value = number_of(input);
    const bool inside =
        value && *value <= allowed.max && (allowed.above_min ? *value > allowed.min : *value >= allowed.min);
    if (inside) return *value;
    return malformed(input, describe(allowed));
}

Result<bool> read_boolean(const Input& input) {
    if (const auto* text = std::get_if<std::string_view>(&input.value)) {
        if (*text == "true" || *text == "1") return true;
        if (*text == "false" || *text == "0") return false;
    } else if (const auto json = std::get<JsonValue>(input.value); json.is_boolean()) {
        return json.boolean();
    }
    return malformed(input, "must be true or false");
}

Result<std::string_view> read_text(const Input& input) {
    if (const auto* text = std::get_if<std::string_view>(&input.value)) return *text;
    const auto json = std::get<JsonValue>(input.value);
    if (json.is_string()) return std::string_view(json.text());
    return malformed(input, "must be a string");
}

Result<JsonDocument> parse_json(const Input& input) {
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    return JsonDocument::parse(*text).map_error([&](Error error) { return error_in_text(std::move(error), input); });
}

Error error_in_text(Error error, const Input& input) {
    constexpr std::string_view kSubject = "the body";
    const std::size_t replaced = error.message.starts_with(kSubject) ? kSubject.size() : 0;
    const bool continues = replaced > 0 || error.message.starts_with('/');
    error.message.replace(0, replaced, input.name + (continues ? "" : ": "));
    error.field = input.field;
    return error;
}

Result<JsonDocument> parse_list(const Input& input) {
    const auto text = read_text(input);
    if (text && trim(*text, " \t\r\n").starts_with('[')) return parse_json(input);
    return malformed(input, "must be a list in JSON");
}

Result<std::vector<Input>> read_list(const Input& input, std::size_t most, std::string_view one) {
    std::vector<Input> members;
    const auto* json = std::get_if<JsonValue>(&input.value);
    if (json != nullptr && json->is_array()) {
        if (json->size() > most) return members;
        for (const JsonValue value : *json) {
            const std::string pointer = pointer_below(input.field, members.size());
            members.push_back({pointer, pointer, value});
        }
        return members;
    }
    auto text = read_text(input);
    if (!text) return malformed(input, "must be a string or an array");
    auto remaining = text->empty() ? 0 : static_cast<std::size_t>(std::ranges::count(*text, ',')) + 1;
    if (remaining > most) return members;
    for (; remaining > 0; --remaining) {
        const std::string name = input.name + ": " + std::string(one) + ' ' + std::to_string(members.size() + 1);
        members.push_back({name, input.field, trim(take_until(*text, ","))});
    }
    return members;
}

Result<std::size_t> read_word(const Input& input, std::span<const std::string_view> words) {
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    const auto found = std::find(words.begin(), words.end(), *text);
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
    std::string list = "is '" + excerpt(*text) + "', but must be";
    for (const auto word : words) {
        list.append(word == words.front() ? " '" : " or '").append(word).append("'");
    }
    return malformed(input, list);
}

Result<std::size_t> read_sites(const Input& input, const Limits& limits) {
    const auto sites = integer_of(input);
    if (!sites || *sites == 0) {
        return malformed(input, "must be an integer from 1 to " + std::to_string(limits.max_sites));
    }
    if (*sites > limits.max_sites) {
        return failure(ErrorCode::LimitExceeded,
                       input.name + " is " + std::to_string(*sites) + "; this server's limit (max-sites) is " +
                           std::to_string(limits.max_sites),
                       input.field);
    }
    return static_cast<std::size_t>(*sites);
}

void ErrorList::add(const Error& error) {
    if (!first_) {
        first_ = error;
        return;
    }
    auto& others = first_->others;
    others.push_back({error.code, error.message, error.field});
    others.insert(others.end(), error.others.begin(), error.others.end());
    if (others.size() > kMaxOthers) others.resize(kMaxOthers);
}

Result<void> ErrorList::result() const {
    if (!first_) return {};
    return tl::unexpected(*first_);
}

Error error_below(Error error, std::string_view pointer) {
    if (error.field.empty() || error.field.starts_with('/')) {
        error.field.insert(0, pointer);
    } else {
        error.field = pointer_below(pointer, error.field);
    }
    return error;
}

std::string excerpt(std::string_view text) {
    std::string result(text.substr(0, kMaxExcerpt));
    std::ranges::replace_if(
        result, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    if (text.size() > kMaxExcerpt) result += "...";
    return result;
}

std::string join_names(std::span<const std::string> names) {
    constexpr std::size_t kMax = 10;
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), kMax); ++i)
        list.append(i == 0 ? "" : ", ").append(excerpt(names[i]));
    return names.size() > kMax ? list + " and others" : list;
}

std::vector<Input> inputs_of(const std::vector<TextOption>& options) {
    std::vector<Input> inputs;
    inputs.reserve(options.size());
    for (const auto& option : options) {
        inputs.push_back({option.name, option.name, std::string_view(option.value)});
    }
    return inputs;
}

Result<std::vector<Input>> inputs_of(JsonValue object, std::string_view pointer) {
    if (!object.is_object()) {
        const std::string subject = pointer.empty() ? "the body" : std::string(pointer);
        return failure(ErrorCode::Malformed, subject + " must be a JSON object", std::string(pointer));
    }
    if (object.size() > kMaxMembers) {
        return failure(ErrorCode::Malformed, "a JSON object has more members than there are options",
                       std::string(pointer));
    }
    std::vector<Input> inputs;
    inputs.reserve(object.size());
    for (const auto& [name, value] : object.members()) {
        const std::string field = pointer_below(pointer, name);
        inputs.push_back({pointer.empty() ? std::string(name) : field, field, value});
    }
    return inputs;
}

}  // namespace ccdt::api

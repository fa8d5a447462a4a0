// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/request.h"

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <utility>

#include "api/analyze/point_file_reader.h"
#include "api/halftone/device_picture.h"
#include "api/image/image_header.h"
#include "api/input/domain_reader.h"
#include "api/input/negotiation.h"
#include "api/input/npy_reader.h"
#include "api/json/json_document.h"
#include "api/operation/body_kind.h"
#include "api/output/json_pieces.h"
#include "api/sample/plane/sample_cost.h"
#include "api/sample/spatial/voxel_input.h"
#include "api/surface/surface_header.h"
#include "api/text/base64.h"
#include "api/text/file_kind.h"
#include "api/text/text.h"
#include "core/geometry/axes.h"
#include "server/cli/files.h"

namespace ccdt::server {
namespace {

/// Whether a file may be a binary STL: the number at the position of the number of facets is within the largest limit.
/// @param head  the first 84 bytes or more
bool may_be_binary_stl(std::string_view head) {
    constexpr std::size_t kCount = 80;  // offset of the number, with the lowest byte first
    std::size_t facets = 0;
    for (std::size_t i = 4; i-- > 0;) facets = facets << 8 | static_cast<unsigned char>(head[kCount + i]);
    return facets > 0 && facets <= kMaxFaces;
}

/// Replaces the subject of a message about a body, which is a file or a value here.
std::string with_subject(std::string_view subject, std::string message) {
    constexpr std::string_view kBody = "the body";
    if (message.starts_with(kBody)) message.replace(0, kBody.size(), subject);
    return message;
}

/// Appends the value of an option as JSON. The parser of the API judges whether its type is right.
Result<void> append_value(std::string& body, const Arguments::Given& given) {
    const auto& [option, value, typed] = given;
    if (option->is_flag() && (value == "true" || value == "false")) {
        body += value;
        return {};
    }
    if (option->takes_json && api::begins_like_json(value)) {
        if (const auto parsed = api::JsonDocument::parse(value); !parsed)
            return failure(parsed.error().code, with_subject(option->member, parsed.error().message), option->member);
        body += value;
        return {};
    }
    if (option->takes_number) {
        const auto parsed = api::JsonDocument::parse(value);
        if (parsed && parsed->root().is_number()) {
            body += value;
            return {};
        }
    }
    api::append_json_text(body, value);
    return {};
}

/// Builds a JSON object from all options, after `first`, which is the beginning of an object.
Result<std::string> build_object(std::string first, const Arguments& arguments) {
    std::string body = std::move(first);
    for (const auto& given : arguments.given) {
        if (body.size() > 1) body += ',';
        api::append_json_text(body, given.option->member);
        body += ':';
        if (auto appended = append_value(body, given); !appended) return tl::unexpected(appended.error());
    }
    return body += '}';
}

template <class P>
std::string list_of(const std::vector<P>& points) {
    std::string text;
    api::append_array(text, points, [](std::string& out, const P& point) {
        api::append_numbers(out, std::bit_cast<std::array<double, kAxes<P>>>(point));
    });
    return text;
}

/// Whether an option names the file of the mesh on which points are analysed.
bool names_mesh(const Option& option) {
    return option.member == "mesh" && !option.is_flag();
}

/// Returns the mesh on which points are analysed; null if there is none.
const std::string* find_mesh(const Arguments& arguments) {
    const auto found =
        std::ranges::find_if(arguments.given, [](const auto& given) { return names_mesh(*given.option); });
    return found == arguments.given.end() ? nullptr : &found->value;
}

/// Whether the option `domain` is a box or torus in space, as an object.
/// @param otherwise  the result if the option is absent or a word
bool is_in_space(const Arguments& arguments, bool otherwise) {
    const std::string* const domain = arguments.find("domain");
    if (domain == nullptr || !api::begins_like_json(*domain)) return otherwise;
    const auto parsed = api::JsonDocument::parse(*domain);
    return parsed && api::is_box(parsed->root());
}

/// Whether the service accepts the options beside this body as query parameters.
bool takes_query(const Arguments& arguments) {
    return std::ranges::none_of(arguments.given, [](const auto& given) { return given.option->in_body; });
}

Result<std::string> build_sample_body(const Arguments& arguments, const std::string* map) {
    if (map == nullptr) return build_object("{", arguments);
    const auto parsed = api::parse_sample_document(*map);
    if (!parsed) return tl::unexpected(parsed.error());
    std::string body = R"({"geometry":)";
    api::append_json(body, parsed->root());
    return build_object(std::move(body), arguments);
}

Result<std::string> build_analyze_body(const Arguments& arguments, const std::string* file) {
    if (file == nullptr) return build_object("{", arguments);
    const auto build = [&](const auto& points) { return build_object(R"({"points":)" + list_of(points), arguments); };
    if (is_in_space(arguments, api::is_point_file3(*file)))
        return api::read_point_file3(*file, arguments.limits).and_then(build);
    return api::read_point_file(*file, arguments.limits).and_then(build);
}

/// Returns the formats between which a command chooses.
std::vector<const api::FileFormat*> formats_of(const Command& command, const Arguments& arguments) {
    if (arguments.find("device") != nullptr) return api::files_of(api::device_formats());
    return command.formats();
}

}  // namespace

Result<ApiRequest> build_request(const Command& command, const Arguments& arguments, const std::string* input) {
    if (command.name == "choose") {
        ApiRequest request{input != nullptr ? *input : std::string(), {{"candidates", "body"}}};
        for (const auto& [option, value, typed] : arguments.given) request.options.push_back({option->member, value});
        return request;
    }
    const std::string* const mesh = find_mesh(arguments);
    const std::string* const density = arguments.find("density");
    const bool has_voxels = input == nullptr && density != nullptr && api::is_voxel_file(*density);
    const std::string* const file = mesh != nullptr ? mesh : has_voxels ? density : input;
    const bool is_binary =
        file != nullptr && command.name == "sample" && (api::recognise_surface(*file) || api::is_voxel_file(*file));
    if (mesh != nullptr || (file != nullptr && command.name != "analyze" && (is_binary || takes_query(arguments)))) {
        ApiRequest request{*file, {}};
        if (mesh != nullptr && input != nullptr) request.options.push_back({"points", *input});
        for (const auto& [option, value, typed] : arguments.given) {
            if (&value != file) request.options.push_back({option->member, value});
        }
        return request;
    }
    auto body = command.name == "analyze" ? build_analyze_body(arguments, input) : build_sample_body(arguments, input);
    return std::move(body).map([](std::string text) { return ApiRequest{std::move(text), {}}; });
}

Result<bool> set_output(const Command& command, const api::FileFormat& format, bool is_split, std::string& input) {
    if (command.name != "sample" || !api::begins_like_json(input)) return false;
    const auto parsed = api::JsonDocument::parse(input);
    if (!parsed || !parsed->root().is_object() || !api::kind_of_json(parsed->root()).empty()) return false;
    const auto given = parsed->root().find("format");
    const bool splits = parsed->root().find("split").has_value();
    const auto formats = command.formats();
    const auto found = std::ranges::find_if(formats, [&](const api::FileFormat* each) {
        return given && given->is_string() && each->name == given->text();
    });
    // The parser reports an unknown name.
    if (found != formats.end() && (*found)->extension != format.extension)
        return failure(ErrorCode::Malformed, "the input has the format " + given->text(), "format");
    if (splits && !is_split)
        return failure(ErrorCode::Malformed,
                       "the input has the option split, which makes several files: use {ink} in --output, as in "
                       "'{name}-{ink}.svg', or standard output for a ZIP archive",
                       "output");
    std::string added;
    if (!given) added += R"("format":")" + std::string(format.name) + "\",";
    if (is_split && !splits) added += R"("split":"ink",)";
    if (parsed->root().size() == 0 && !added.empty()) added.pop_back();
    input.insert(input.find('{') + 1, added);
    return true;
}

std::size_t parsing_memory(std::string_view input) {
    return api::begins_like_json(input) ? api::cost_of_parsing(input).memory : 0;
}

Result<api::ParsedPointer> parse_request(const Command& command, const ApiRequest& request, const api::Limits& limits) {
    const auto& [body, options] = request;
    if (command.name == "halftone")
        return api::parse_halftone_request(body, api::HalftoneBody::Picture, options, "", limits);
    if (command.name != "analyze") return api::parse_sample_request(body, options, "", limits);
    return api::parse_analyze_request(body, options, "", limits);
}

Result<void> check_head(const Command& command, std::string_view head) {
    if (command.name == "halftone") return api::recognise_image(head).map([](api::ImageFormat) {});
    const bool has_only_text = head.find('\0') == std::string_view::npos;
    if (has_only_text || api::recognise_image(head) || api::is_npy(head) || api::recognise_surface(head) ||
        may_be_binary_stl(head) || !api::kind_of_file(head).empty())
        return {};
    return failure(ErrorCode::Unsupported, "this is neither a text nor a binary file of a known kind");
}

Result<void> read_value_files(Arguments& arguments) {
    std::vector<std::string*> files;
    for (auto& [option, value, typed] : arguments.given) {
        const bool is_mesh = names_mesh(*option);
        if (!is_mesh && (!option->takes_json || !value.starts_with('@'))) continue;
        const std::string file = value.substr(value.starts_with('@') ? 1 : 0);
        auto content = read_file(file, arguments.memory,
                                 [](std::string_view head) { return check_head(*find_command("sample"), head); });
        if (content && is_mesh && !api::recognise_surface(*content))
            content = failure(ErrorCode::Unsupported, "this is not an STL, OBJ, PLY, OFF, GLB or glTF file");
        if (!content) return failure(content.error().code, file + ": " + content.error().message, option->member);
        value = *std::move(content);
        if (!is_mesh) files.push_back(&value);
    }
    // Only now, the domain is known. Words are for surfaces, which have lists of densities, and for space.
    const bool in_space = is_in_space(arguments, arguments.find("domain") != nullptr);
    for (std::string* const value : files) {
        const bool is_kept =
            api::begins_like_json(*value) || api::is_npy(*value) || (in_space && api::is_voxel_file(*value));
        if (!is_kept) *value = R"({"image":")" + api::base64(*value) + R"("})";
    }
    return {};
}

Result<const api::FileFormat*> find_format(const Command& command, const Arguments& arguments,
                                           const std::string& output) {
    const auto formats = formats_of(command, arguments);
    if (const std::string* const name = arguments.find("format")) {
        const auto found = std::ranges::find(formats, *name, &api::FileFormat::name);
        return found == formats.end() ? formats.front() : *found;  // the parser reports an unknown name
    }
    const auto found = api::format_of_suffix(std::filesystem::path(output).extension().string(), formats);
    if (found) return formats[*found];
    if (!output_target(output).is_replaced) return formats.front();
    return failure(ErrorCode::Malformed,
                   "output " + output + ": " + found.error().message + ", or --format must be given", "output");
}

bool is_text(const api::FileFormat& format) {
    const std::string_view type = format.media_type;
    return type.starts_with("text/") || type.find("json") != std::string_view::npos || type.ends_with("+xml");
}

namespace {

bool is_part_of_name(char c) {
    return c == '_' || c == '-' || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

/// Replaces names of members that no word of a sentence has, such as `width_mm`, by their flags.
void name_flags(std::string& message, std::span<const Option> options) {
    for (const Option& option : options) {
        const std::string& member = option.member;
        if (member.find('_') == std::string::npos) continue;
        for (std::size_t at = 0; (at = message.find(member, at)) != std::string::npos;) {
            const std::size_t end = at + member.size();
            const bool is_name = (at == 0 || !is_part_of_name(message[at - 1])) &&
                                 (end == message.size() || !is_part_of_name(message[end]));
            const std::string flag = is_name ? "--" + option.name : member;
            message.replace(at, member.size(), flag);
            at += flag.size();
        }
    }
}

}  // namespace

DescribedError describe_error(const Error& error, std::span<const Option> options) {
    // The limits of the service are flags of the program.
    constexpr std::string_view kLimit = "this server's limit (";
    std::string message = with_subject("the input", error.message);
    if (const auto at = message.find(kLimit); at != std::string::npos) {
        message.replace(at, kLimit.size(), "the limit (--");
        constexpr std::string_view kOfBodies = "--max-body, memory";
        if (const auto both = message.find(kOfBodies); both != std::string::npos)
            message.replace(both, kOfBodies.size(), "--memory");
    }
    std::string_view rest = error.field;
    if (rest.starts_with('/')) rest.remove_prefix(1);
    const auto member = rest.substr(0, rest.find('/'));
    rest.remove_prefix(member.size());
    const auto is_named = [member](const Option& option) {
        return !member.empty() && member == (option.member.empty() ? option.name : option.member);
    };
    const auto option = std::ranges::find_if(options, is_named);
    if (option == options.end()) {
        // The message may not say which part of the input is wrong.
        if (!message.starts_with(error.field)) message.insert(0, error.field + ": ");
        return {{}, std::move(message)};
    }
    const std::string flag = "--" + option->name;
    const bool repeats_field = message.starts_with(error.field) || message.starts_with(member);
    const std::size_t length = message.starts_with(error.field) ? error.field.size() : member.size();
    std::string text =
        repeats_field ? (length > member.size() ? std::string(rest) : "") + message.substr(length) : ": " + message;
    name_flags(text, options);
    return {flag, flag + text};
}

}  // namespace ccdt::server

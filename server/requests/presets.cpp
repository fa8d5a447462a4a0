// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/presets.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/json/json_document.h"
#include "api/sample/choice/choice_parser.h"
#include "api/sample/pixels/pixel_sample.h"
#include "api/sample/plane/sample_parser.h"
#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_sample.h"
#include "api/text/similar_name.h"
#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kParameter = "preset";
constexpr std::size_t kMaxNameLength = 64;

/// Lists the options of /halftone and /sample.
std::vector<std::string> known_options() {
    std::vector<std::string> names;
    for (const auto& options :
         {api::halftone_options(), api::device_options(), api::sample_options(), api::pixel_options(),
          api::choice_options(), api::surface_options(), api::volume_options()})
        names.insert(names.end(), options.begin(), options.end());
    return names;
}

/// Returns "; did you mean NAME?" if a name is similar to a misspelt one.
std::string hint(const std::vector<std::string>& names, std::string_view misspelt) {
    const std::string* const similar = api::find_similar(names, misspelt);
    return similar == nullptr ? "" : "; did you mean " + *similar + "?";
}

tl::unexpected<Error> wrong(const std::string& message) {
    return failure(ErrorCode::Malformed, message, std::string(kParameter));
}

Result<std::vector<api::TextOption>> parse_options(const std::string& preset, api::JsonValue json,
                                                   const std::vector<std::string>& known) {
    if (!json.is_object() || json.size() == 0) return wrong(preset + " must be an object with options");
    std::vector<api::TextOption> options;
    for (const auto& [name, value] : json.members()) {
        if (std::ranges::find(known, name) == known.end())
            return wrong(preset + ": there is no option '" + std::string(name) + "'" + hint(known, name));
        std::string text;
        if (value.is_string())
            text = value.text();
        else
            api::append_json(text, value);
        options.push_back({std::string(name), std::move(text)});
    }
    return options;
}

}  // namespace

Result<Presets> Presets::parse(std::string_view json) {
    const auto document = api::JsonDocument::parse(json);
    if (!document) {
        constexpr std::string_view kBody = "the body";
        std::string message = document.error().message;
        if (message.starts_with(kBody)) message.replace(0, kBody.size(), "the file");
        return wrong(message);
    }
    if (!document->root().is_object()) return wrong("presets must be members of an object");
    const auto known = known_options();
    Presets presets;
    for (const auto& [member, value] : document->root().members()) {
        const std::string name(member);
        if (!api::is_plain_name(name, kMaxNameLength))
            return wrong("the name of a preset must have 1 to 64 letters, digits, dots or dashes, not '" + name + "'");
        auto options = parse_options(name, value, known);
        if (!options) return tl::unexpected(options.error());
        presets.presets_.emplace(name, *std::move(options));
    }
    return presets;
}

Result<void> Presets::expand(ComputeRequest& request, std::vector<FormPart>& fields, bool only) const {
    std::vector<std::string> names;  // of the given presets
    std::vector<std::string> own;    // names of other options
    const auto take = [&](const std::string& name, std::string_view value) {
        const bool is_preset = name == kParameter;
        (is_preset ? names : own).emplace_back(is_preset ? value : name);
        return is_preset;
    };
    std::vector<api::TextOption> given = parse_query(request.query);
    std::erase_if(given, [&](const auto& option) { return take(option.name, option.value); });
    std::erase_if(fields, [&](const FormPart& field) { return take(field.name, field.content(request.body)); });
    if (names.empty() && !only) return {};
    if (names.size() != 1)
        return wrong(names.empty() ? "this server needs preset=NAME (presets-only)" : "preset is given more than once");
    if (only && !given.empty())
        return failure(ErrorCode::Malformed, "this server accepts no options besides a preset (presets-only)",
                       given.front().name);
    const auto found = presets_.find(names.front());
    if (found == presets_.end())
        return wrong(presets_.empty()
                         ? "this server has no presets (presets)"
                         : "there is no preset '" + names.front() + "'" + hint(this->names(), names.front()));
    request.query.clear();
    const auto add = [&query = request.query](const api::TextOption& option) {
        query += (query.empty() ? "" : "&") + encode_percent(option.name) + '=' + encode_percent(option.value);
    };
    for (const auto& option : found->second) {
        if (std::ranges::find(own, option.name) == own.end()) add(option);
    }
    for (const auto& option : given) add(option);
    return {};
}

std::vector<std::string> Presets::names() const {
    std::vector<std::string> names;
    for (const auto& [name, options] : presets_) names.push_back(name);
    return names;
}

}  // namespace ccdt::server

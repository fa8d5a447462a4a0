// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/negotiation.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <vector>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

/// A media range such as `type/subtype;q=0.5`; a star matches anything.
struct MediaRange {
    std::string type;
    std::string subtype;
    double quality = 1;

    /// Returns how specifically the range matches a media type: 3 by type and subtype, 2 by type, 1 as `*/*`, 0 if it
    /// does not match.
    int match(std::string_view media_type) const {
        const auto slash = media_type.find('/');
        if (type == "*") return 1;
        if (type != media_type.substr(0, slash)) return 0;
        if (subtype == "*") return 2;
        return subtype == media_type.substr(slash + 1) ? 3 : 0;
    }
};

/// Removes from `rest` the text up to the first separator outside quotes. Returns this text without the separator.
std::string_view take_item(std::string_view& rest, char separator) {
    bool quoted = false;
    std::size_t i = 0;
    for (; i < rest.size() && (quoted || rest[i] != separator); ++i) {
        if (rest[i] == '"') quoted = !quoted;
        if (quoted && rest[i] == '\\') ++i;
    }
    const auto head = rest.substr(0, i);
    rest = i < rest.size() ? rest.substr(i + 1) : std::string_view();
    return trim(head);
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return result;
}

std::optional<double> parse_quality(std::string_view text) {
    const auto value = parse_number<double>(text, std::chars_format::fixed);
    return value && *value >= 0 && *value <= 1 ? value : std::nullopt;
}

std::optional<MediaRange> parse_range(std::string_view text) {
    const std::string name = lower(take_item(text, ';'));
    const auto slash = name.find('/');
    if (slash == std::string::npos || slash == 0 || slash + 1 == name.size()) return std::nullopt;
    MediaRange range{name.substr(0, slash), name.substr(slash + 1)};
    if (range.type == "*" && range.subtype != "*") return std::nullopt;
    while (!text.empty()) {
        const std::string parameter = lower(take_item(text, ';'));
        if (!parameter.starts_with("q=")) continue;
        const auto quality = parse_quality(std::string_view(parameter).substr(2));
        if (!quality) return std::nullopt;
        range.quality = *quality;
    }
    return range;
}

std::vector<MediaRange> parse_accept(std::string_view accept) {
    std::vector<MediaRange> ranges;
    while (!accept.empty()) {
        if (auto range = parse_range(take_item(accept, ','))) ranges.push_back(*std::move(range));
    }
    return ranges;
}

double quality_of(std::string_view media_type, const std::vector<MediaRange>& ranges) {
    int best = 0;
    double quality = 0;
    for (const auto& range : ranges) {
        if (const int match = range.match(media_type); match > best) {
            best = match;
            quality = range.quality;
        }
    }
    return quality;
}

std::string list(std::span<const FileFormat* const> formats, std::string_view FileFormat::*what) {
    std::string text;
    for (const FileFormat* format : formats) {
        if (!text.empty()) text += ", ";
        text += format->*what;
    }
    return text;
}

}  // namespace

Result<std::size_t> format_of_suffix(std::string_view suffix, std::span<const FileFormat* const> offered) {
    std::string name = lower(suffix.substr(std::min<std::size_t>(suffix.size(), 1)));
    if (name == "tif") name = "tiff";
    if (name == "nc" || name == "ngc" || name == "gc") name = "gcode";
    const auto matches = [&](const FileFormat* format) { return format->extension == name || format->name == name; };
    const auto found = std::find_if(offered.begin(), offered.end(), matches);
    if (found != offered.end()) return static_cast<std::size_t>(found - offered.begin());
    std::vector<std::string_view> known;
    for (const FileFormat* format : offered) {
        if (std::find(known.begin(), known.end(), format->extension) == known.end()) known.push_back(format->extension);
    }
    std::string message = "the suffix names no format; it must be one of";
    for (const auto extension : known) message.append(extension == known.front() ? " ." : ", .").append(extension);
    return failure(ErrorCode::Malformed, std::move(message));
}

Result<std::size_t> read_format(const Input& input, std::span<const FileFormat* const> offered) {
    const auto name = read_text(input);
    if (!name) return tl::unexpected(name.error());
    const auto found =
        std::find_if(offered.begin(), offered.end(), [&](const FileFormat* f) { return f->name == *name; });
    if (found != offered.end()) return static_cast<std::size_t>(found - offered.begin());
    return failure(
        ErrorCode::Malformed,
        "format '" + excerpt(*name) + "' is not available here; the formats are " + list(offered, &FileFormat::name),
        input.field);
}

Result<std::size_t> negotiate(std::string_view accept, std::span<const FileFormat* const> offered) {
    const auto ranges = parse_accept(accept);
    if (ranges.empty()) return 0;
    std::size_t chosen = 0;
    double best = 0;
    for (std::size_t i = 0; i < offered.size(); ++i) {
        if (const double quality = quality_of(offered[i]->media_type, ranges); quality > best) {
            chosen = i;
            best = quality;
        }
    }
    if (best > 0) return chosen;
    return failure(ErrorCode::NotAcceptable,
                   "no media type of the header Accept is available here; the media types are " +
                       list(offered, &FileFormat::media_type));
}

}  // namespace ccdt::api

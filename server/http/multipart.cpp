// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/multipart.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kBlankLine = "\r\n\r\n";
constexpr std::size_t kLongestBoundary = 70;
constexpr std::size_t kLargestHeaders = 16'384;  ///< limit for one part
constexpr std::size_t kMaxParts = 1'000;

/// Whether a text is a valid boundary: RFC 2046, section 5.1.1.
bool is_boundary(std::string_view text) {
    const auto is_allowed = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("'()+_,-./:=? ").find(c) != std::string_view::npos;
    };
    return !text.empty() && text.size() <= kLongestBoundary && text.back() != ' ' &&
           std::ranges::all_of(text, is_allowed);
}

/// Reads the name from the Content-Disposition of a part, and whether there is a file name.
HttpResult<FormPart> part_name(std::string_view headers) {
    std::optional<std::string> name;
    bool is_file = false;
    while (!headers.empty()) {
        const auto line = api::take_until(headers, kLineEnd);
        const auto colon = line.find(':');
        if (colon == std::string_view::npos || !equals_ignoring_case(line.substr(0, colon), "Content-Disposition"))
            continue;
        if (name) return problem(400, "a part of the form has more than one Content-Disposition");
        name = header_parameter(line.substr(colon + 1), "name");
        is_file = !header_parameter(line.substr(colon + 1), "filename").empty();
    }
    if (!name || name->empty()) return problem(400, "a part of the form has no name, or more than one");
    return FormPart{*std::move(name), 0, 0, is_file};
}

/// Finds the beginning of the content of a part, after its headers.
/// @param at  position after the preceding boundary
HttpResult<std::size_t> skip_headers(std::string_view body, std::size_t at) {
    const auto window = body.substr(at, kLargestHeaders);
    const auto padding = std::min(window.find_first_not_of(" \t"), window.size());
    const auto end = window.find(kBlankLine);
    const auto follows = window.substr(padding, kLineEnd.size());
    if (!kLineEnd.starts_with(follows)) return problem(400, "a boundary of the form is not followed by a line end");
    if (end != std::string_view::npos) return at + end + kBlankLine.size();
    if (window.size() == kLargestHeaders)
        return problem(400, "the headers of a part of the form take more than 16384 bytes");
    return problem(400, "the form ends within the headers of a part");
}

}  // namespace

HttpResult<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view content_type) {
    const std::string boundary = header_parameter(content_type, "boundary");
    if (boundary.empty()) return problem(400, "the form's Content-Type names no boundary, or more than one");
    if (!is_boundary(boundary))
        return problem(400, "the form's boundary must have 1 to 70 of the characters that RFC 2046 allows");
    // The delimiter contains only one CR, its first character, so a search reads each byte of the body at most twice.
    const std::string delimiter = "\r\n--" + boundary;
    const auto truncated = [] { return problem(400, "the form ends before its last boundary"); };

    std::size_t at = delimiter.size() - kLineEnd.size();  // position after a boundary
    if (!body.starts_with(std::string_view(delimiter).substr(kLineEnd.size()))) {
        const auto first = body.find(delimiter);
        if (first == std::string_view::npos) return truncated();
        at = first + delimiter.size();
    }
    std::vector<FormPart> parts;
    while (body.substr(at, 2) != "--") {
        if (parts.size() == kMaxParts) return problem(400, "the form has more than 1000 parts");
        const auto begin = skip_headers(body, at);
        if (!begin) return tl::unexpected(begin.error());
        auto part = part_name(body.substr(at, *begin - at));
        if (!part) return tl::unexpected(part.error());
        const auto end = body.find(delimiter, *begin);
        if (end == std::string_view::npos) return truncated();
        part->begin = *begin;
        part->size = end - *begin;
        parts.push_back(*std::move(part));
        at = end + delimiter.size();
    }
    return parts;
}

}  // namespace ccdt::server

#include "server/http/multipart.h"

#include <utility>

namespace ccdt::server {
namespace {

/// The name in a part's Content-Disposition.
std::string part_name(std::string_view headers) {
    while (!headers.empty()) {
        const auto end = headers.find("\r\n");
        const auto line = headers.substr(0, end);
        headers.remove_prefix(end == std::string_view::npos ? headers.size() : end + 2);
        const auto colon = line.find(':');
        if (colon != std::string_view::npos && equals_ignoring_case(line.substr(0, colon), "Content-Disposition"))
            return header_parameter(line.substr(colon + 1), "name");
    }
    return {};
}

}  // namespace

Received<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view content_type) {
    const std::string boundary = header_parameter(content_type, "boundary");
    if (boundary.empty()) return fault(400, "the form's Content-Type names no boundary");
    const std::string delimiter = "--" + boundary;
    const auto truncated = [] { return fault(400, "the form ends before its last boundary"); };

    std::vector<FormPart> parts;
    std::size_t at = body.find(delimiter);
    while (at != std::string_view::npos) {
        at += delimiter.size();
        if (body.substr(at, 2) == "--") return parts;
        const auto headers_begin = body.find("\r\n", at);
        if (headers_begin == std::string_view::npos) return truncated();
        const auto headers_end = body.find("\r\n\r\n", headers_begin);
        if (headers_end == std::string_view::npos) return truncated();
        const auto begin = headers_end + 4;
        const auto end = body.find("\r\n" + delimiter, begin);
        if (end == std::string_view::npos) return truncated();

        auto name = part_name(body.substr(headers_begin, headers_end - headers_begin));
        if (name.empty()) return fault(400, "a part of the form has no name");
        parts.push_back({std::move(name), begin, end - begin});
        at = end + 2;
    }
    return truncated();
}

}  // namespace ccdt::server

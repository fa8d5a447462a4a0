// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/multipart.h"

#include <algorithm>

#include "server/http/http.h"
#include "server/requests/form.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

/// Checks that each part lies between two boundaries, after the previous part, and contains no boundary.
void check_parts(const std::vector<server::FormPart>& parts, std::string_view body, std::string_view content_type) {
    const auto boundary = server::header_parameter(content_type, "boundary");
    CCDT_CHECK(boundary.size() <= 70 && boundary.find_first_of("\r\n\"") == std::string::npos);
    CCDT_CHECK(parts.size() <= 1000);
    const std::string delimiter = "\r\n--" + boundary;
    std::size_t end = 0;
    for (const auto& part : parts) {
        CCDT_CHECK(!part.name.empty());
        CCDT_CHECK(part.begin >= end + 4 && part.begin <= body.size() && part.size <= body.size() - part.begin);
        CCDT_CHECK(body.substr(part.begin - 4, 4) == "\r\n\r\n");
        end = part.begin + part.size;
        CCDT_CHECK(body.substr(end).starts_with(delimiter));
        CCDT_CHECK(part.content(body).find(delimiter) == std::string_view::npos);
    }
}

/// Checks that text after the last boundary is ignored.
void check_epilogue(const std::vector<server::FormPart>& parts, std::string_view body, std::string_view content_type) {
    const auto again = server::parse_multipart(std::string(body) + "\r\nepilogue", content_type);
    CCDT_CHECK(again && again->size() == parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto& a = parts[i];
        const auto& b = (*again)[i];
        CCDT_CHECK(a.name == b.name && a.begin == b.begin && a.size == b.size);
    }
}

/// Checks that a form with one picture is split into the picture and a query with all other fields.
void check_apart(const std::vector<server::FormPart>& parts, std::string_view body, std::string_view content_type) {
    if (server::media_type(content_type) != "multipart/form-data") return;
    server::ComputeRequest request{"/halftone", "a=b", std::string(content_type), "", std::string(body)};
    const auto is_picture = [](const server::FormPart& part) { return part.name == "image" || part.name == "file"; };
    const auto picture = std::ranges::find_if(parts, is_picture);
    const auto apart = server::take_apart(request, parts);
    CCDT_CHECK(apart.has_value() == (std::ranges::count_if(parts, is_picture) == 1));
    if (!apart) return;
    CCDT_CHECK(request.body == picture->content(body));
    const auto options = server::parse_query(request.query);
    CCDT_CHECK(options.size() == parts.size());
    CCDT_CHECK(options.front().name == "a" && options.front().value == "b");
    auto next = options.begin() + 1;
    for (const auto& part : parts) {
        if (is_picture(part)) continue;
        CCDT_CHECK(next->name == part.name && next->value == part.content(body));
        ++next;
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses a form. The input is a line with the Content-Type, then the body.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto body = fuzz::text_of(data, size);
    const auto content_type = fuzz::take_line(body);
    const auto parts = server::parse_multipart(body, content_type);
    if (parts) {
        fuzz::check_parts(*parts, body, content_type);
        fuzz::check_epilogue(*parts, body, content_type);
        fuzz::check_apart(*parts, body, content_type);
    } else {
        fuzz::check_problem(parts.error());
        CCDT_CHECK(parts.error().status == 400);
    }
    return 0;
}

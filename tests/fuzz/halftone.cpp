// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/http/http.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/halftone_checks.h"
#include "tests/support/halftone_requests.h"

namespace ccdt::fuzz {
namespace {

using std::string_view_literals::operator""sv;

/// The first bytes of a JPEG of 2 x 1 pixels. The parser reads only its frame header.
constexpr std::string_view kImage = "\xff\xd8\xff\xc0\0\x0b\x08\0\1\0\2\1"sv;

void append_escaped(std::string_view text, std::string& query) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        query += '%';
        query += kDigits[byte >> 4];
        query += kDigits[byte & 15];
    }
}

/// Checks that options survive a round trip through a query.
void check_query(std::string_view query, const std::vector<api::TextOption>& options) {
    CCDT_CHECK(options.size() <= static_cast<std::size_t>(std::ranges::count(query, '&')) + 1);
    std::string again;
    for (const auto& [name, value] : options) {
        CCDT_CHECK(name.size() + value.size() <= query.size());
        append_escaped(name, again);
        again += '=';
        append_escaped(value, again);
        again += '&';
    }
    const auto same = [](const api::TextOption& a, const api::TextOption& b) {
        return a.name == b.name && a.value == b.value;
    };
    CCDT_CHECK(std::ranges::equal(server::parse_query(again), options, same));
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses a request to /halftone. The input is a line with the query, then the Accept header.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto accept = fuzz::text_of(data, size);
    const auto query = fuzz::take_line(accept);
    const auto options = server::parse_query(query);
    fuzz::check_query(query, options);
    const auto request = api::parse_halftone(fuzz::kImage, options, accept, fuzz::kHalftoneLimits);
    if (request) {
        fuzz::check_request(*request);
        CCDT_CHECK(request->image.bytes == fuzz::kImage);
    } else {
        fuzz::check_error(request.error(), options);
    }
    return 0;
}

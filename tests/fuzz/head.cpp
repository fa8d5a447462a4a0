// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/http/http.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using server::Header;
using server::Request;

bool is_visible(std::string_view text) {
    return std::ranges::none_of(text, [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == 0x7f; });
}

bool equal(const Request& a, const Request& b) {
    const auto same = [](const Header& x, const Header& y) { return x.name == y.name && x.value == y.value; };
    return a.method == b.method && a.target == b.target && a.resource == b.resource && a.path == b.path &&
           a.query == b.query && std::ranges::equal(a.headers, b.headers, same) &&
           a.content_length == b.content_length && a.chunked == b.chunked && a.is_http_1_0 == b.is_http_1_0 &&
           a.keep_alive == b.keep_alive && a.expects_continue == b.expects_continue;
}

std::string write(const Request& request) {
    std::string head = request.method + ' ' + request.target + (request.is_http_1_0 ? " HTTP/1.0" : " HTTP/1.1");
    for (const auto& [name, value] : request.headers) head += "\r\n" + name + ":\t" + value + "  ";
    return head + "\r\n\r\n";
}

std::ptrdiff_t count(const Request& request, std::string_view name) {
    const auto alike = [name](const Header& header) { return server::equals_ignoring_case(header.name, name); };
    return std::ranges::count_if(request.headers, alike);
}

/// Checks that the length of the body is unambiguous.
void check_framing(const Request& request) {
    CCDT_CHECK(count(request, "Content-Length") == (request.content_length ? 1 : 0));
    CCDT_CHECK(count(request, "Transfer-Encoding") == (request.chunked ? 1 : 0));
    CCDT_CHECK(!(request.chunked && request.content_length));
    CCDT_CHECK(!(request.chunked && request.is_http_1_0));
}

bool begins_ignoring_case(std::string_view text, std::string_view start) {
    return server::equals_ignoring_case(text.substr(0, start.size()), start);
}

/// Checks that the target is a path, an http or https URL with a host, or `*` for OPTIONS.
void check_target(const Request& request) {
    if (request.target == "*") {
        CCDT_CHECK(request.method == "OPTIONS" && request.path == "*" && request.query.empty());
        return;
    }
    CCDT_CHECK(request.path.starts_with('/'));
    if (request.target.starts_with('/')) return;
    const std::size_t scheme = begins_ignoring_case(request.target, "http://") ? 7 : 8;
    CCDT_CHECK(scheme == 7 || begins_ignoring_case(request.target, "https://"));
    CCDT_CHECK(request.target.find_first_of("/?#:", scheme) != scheme && request.target.size() > scheme);
}

void check_request(const Request& request, std::string_view head) {
    CCDT_CHECK(head.starts_with(request.method + ' ' + request.target + ' '));
    CCDT_CHECK(!request.method.empty() && is_visible(request.target));
    CCDT_CHECK(request.path.size() + request.query.size() <= request.target.size());
    for (const auto& [name, value] : request.headers) {
        CCDT_CHECK(!name.empty() && name.find_first_of(" \t:\r\n") == std::string::npos);
        CCDT_CHECK(is_visible(value));
        CCDT_CHECK(count(request, name) > 1 || request.header(name) == value);
    }
    check_target(request);
    check_framing(request);
    const auto again = server::parse_head(write(request));
    CCDT_CHECK(again && equal(request, *again));
    if (const auto checked = server::check_request(request); !checked) check_problem(checked.error());
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the head of a request.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto head = fuzz::text_of(data, size);
    const auto request = server::parse_head(head);
    if (request) {
        fuzz::check_request(*request, head);
    } else {
        fuzz::check_problem(request.error());
    }
    return 0;
}

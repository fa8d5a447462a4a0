// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http_library.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/text/text.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/wire.h"

namespace ccdt::fuzz {
namespace {

using server::Connection;
using server::Header;
using server::HttpResult;
using server::Request;
using server::Response;

constexpr std::size_t kLargestBody = 16'384;
constexpr server::Patience kPatience{std::chrono::milliseconds(1), std::chrono::milliseconds(1)};
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

/// Returns the headers in the sequence of the library, without headers that it omits: empty values, long names. Range,
/// which is hidden from it, comes last.
std::vector<Header> expected_headers(std::vector<Header> headers) {
    std::erase_if(headers, [](const Header& header) {
        const bool is_added = header.name == "REMOTE_ADDR" || header.name == "REMOTE_PORT" ||
                              header.name == "LOCAL_ADDR" || header.name == "LOCAL_PORT";
        return header.value.empty() || header.name.size() > 1'024 || is_added;
    });
    std::ranges::stable_sort(headers, {}, [](const Header& header) {
        return std::pair(server::equals_ignoring_case(header.name, "Range"), server::to_lower_case(header.name));
    });
    return headers;
}

/// Checks that the library parsed a head in the same way as the connection.
void check_same(const Request& parsed, const Request& checked) {
    CCDT_CHECK(parsed.method == checked.method);
    const auto expected = expected_headers(checked.headers);
    const auto same = [](const Header& a, const Header& b) { return a.name == b.name && a.value == b.value; };
    CCDT_CHECK(std::ranges::equal(parsed.headers, expected, same));
}

/// Decodes a body that the connection has accepted, without checks.
/// @param bytes  starts with the body
std::string decode(const Request& request, std::string_view bytes) {
    if (!request.chunked) return std::string(bytes.substr(0, *request.content_length));
    std::string body;
    while (true) {
        const auto line = api::take_until(bytes, "\r\n");
        const auto size = std::stoull(std::string(line), nullptr, 16);
        if (size == 0) return body;
        CCDT_CHECK(size + 2 <= bytes.size());
        body += bytes.substr(0, size);
        bytes.remove_prefix(size + 2);
    }
}

bool may_have_body(const Request& request) {
    return request.method == "POST" || request.method == "PUT" || request.method == "PATCH";
}

/// The ways to send a body.
enum class Way { Whole, Stream, StreamOfKnownLength };

Response response_with(const std::string& body, Way way) {
    Response response;
    response.media_type = "text/plain";
    if (way == Way::Whole) {
        response.body = body;
        return response;
    }
    if (way == Way::StreamOfKnownLength) response.length = body.size();
    response.stream = [body](const server::Send& send, server::Record&) {
        const auto half = std::string_view(body).substr(body.size() / 2);
        return send(std::string_view(body).substr(0, body.size() / 2)) && send("") && send(half);
    };
    return response;
}

/// Checks that a text is exactly one answer with `body`.
void check_answer(std::string_view answer, const Request& request, const std::string& body, bool last) {
    if (answer.starts_with(kContinue)) answer.remove_prefix(kContinue.size());
    CCDT_CHECK(answer.starts_with("HTTP/1.1 200 OK\r\n"));
    const auto end = answer.find("\r\n\r\n");
    CCDT_CHECK(end != std::string_view::npos);
    const auto head = answer.substr(0, end + 2);
    const auto content = answer.substr(end + 4);
    const bool chunked = head.find("\r\nTransfer-Encoding: chunked\r\n") != std::string_view::npos;
    const auto length = "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
    CCDT_CHECK((head.find("\r\nConnection: close\r\n") != std::string_view::npos) == last);
    CCDT_CHECK(head.find("Content-Length") == std::string_view::npos || head.find(length) != std::string_view::npos);
    CCDT_CHECK(chunked != (head.find(length) != std::string_view::npos) || request.is_http_1_0);
    Request framing;
    framing.chunked = chunked;
    framing.content_length = body.size();
    if (request.method == "HEAD")
        CCDT_CHECK(content.empty());
    else
        CCDT_CHECK(chunked ? decode(framing, content) == body && content.ends_with("0\r\n\r\n") : content == body);
}

/// Serves one request.
/// @param bytes  the bytes that the connection has not processed yet
/// @returns      whether another request may follow
bool serve_one(Connection& connection, Wire& wire, std::string_view bytes, Way way) {
    const auto head = connection.read_head();
    const auto head_size = connection.bytes_in();
    const Request checked = head.value_or(Request());
    Request request = checked;
    Response response;
    HttpResult<std::string> body;
    int calls = 0;
    bool last = true;
    const bool written =
        server::process_request(connection, request, response, last, [&](const HttpResult<void>& dispatched) {
            ++calls;
            CCDT_CHECK(dispatched);
            const bool has_handler = may_have_body(checked) || checked.method == "GET" || checked.method == "HEAD" ||
                                     checked.method == "DELETE" || checked.method == "OPTIONS";
            if (has_handler) check_same(request, checked);
            if (may_have_body(checked) && checked.is_framed()) body = connection.read_body(request, kLargestBody);
            CCDT_CHECK(body || body.error().status != 500);
            response = response_with(body ? *body : body.error().error.message, way);
            last = !connection.between_requests() || way == Way::Stream;
        });
    CCDT_CHECK(calls == 1 && written);
    if (head && body && checked.is_framed() && may_have_body(checked)) {
        CCDT_CHECK(connection.between_requests());
        CCDT_CHECK(*body == decode(checked, bytes.substr(head_size)));
    }
    const auto pieces = wire.receive();
    const auto answer = std::accumulate(pieces.begin(), pieces.end(), std::string());
    check_answer(answer, request, body ? *body : body.error().error.message, last);
    return !last;
}

}  // namespace
}  // namespace ccdt::fuzz

/// Serves requests, and checks that Connection and cpp-httplib read them alike. The first byte of the input chooses the
/// Way of the answers; the other bytes are the requests.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    auto bytes = text_of(data, size);
    const Way way = bytes.empty() ? Way::Whole : static_cast<Way>(static_cast<unsigned char>(bytes.front()) % 3);
    bytes.remove_prefix(std::min<std::size_t>(size, 1));
    Wire wire;
    if (!bytes.empty()) wire.send(bytes);
    Connection connection(wire.server(), kPatience);
    while (!bytes.empty() && connection.wait_for_request([](auto) { return true; })) {
        while (bytes.starts_with("\r\n")) bytes.remove_prefix(2);
        if (!serve_one(connection, wire, bytes, way)) break;
        bytes.remove_prefix(connection.bytes_in());
    }
    return 0;
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection.h"

#include <string>
#include <string_view>
#include <vector>

#include "api/text/text.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/wire.h"
#include "tests/server/reading.h"

namespace ccdt::fuzz {
namespace {

using server::Connection;

constexpr std::size_t kMaxBody = 4'096;
constexpr std::size_t kMaxPieces = 8;  ///< below the number of pieces that the system buffers
constexpr int kUntilItCloses = 0;      ///< in place of a status: the connection ended between two requests

/// The result of reading one request. `status` is 200 or the status of the problem.
struct Outcome {
    int status = 200;
    std::string target;
    std::string body;

    friend bool operator==(const Outcome&, const Outcome&) = default;
};

/// Removes the first line and returns it without its CRLF. Checks that it contains no other CR, LF or NUL.
std::string_view take_strict_line(std::string_view& bytes) {
    const auto end = bytes.find("\r\n");
    CCDT_CHECK(end != std::string_view::npos);
    const auto line = bytes.substr(0, end);
    CCDT_CHECK(line.find_first_of(std::string_view("\r\n\0", 3)) == std::string_view::npos);
    bytes.remove_prefix(end + 2);
    return line;
}

/// Checks that chunks can be interpreted in one way only: as `body`, without further bytes.
void check_chunks(std::string_view bytes, std::string_view body) {
    while (true) {
        const auto line = take_strict_line(bytes);
        const auto digits = line.substr(0, line.find_first_not_of("0123456789abcdefABCDEF"));
        CCDT_CHECK(!digits.empty() && digits.size() <= 16);
        CCDT_CHECK(digits.size() == line.size() || line.find_first_not_of(" \t", digits.size()) == line.find(';'));
        const auto size = std::stoull(std::string(digits), nullptr, 16);
        if (size == 0) break;
        CCDT_CHECK(size <= body.size() && bytes.substr(0, size) == body.substr(0, size));
        body.remove_prefix(size);
        bytes.remove_prefix(size);
        CCDT_CHECK(take_strict_line(bytes).empty());
    }
    CCDT_CHECK(body.empty());
    for (auto line = take_strict_line(bytes); !line.empty(); line = take_strict_line(bytes)) {
        const auto name = line.substr(0, line.find(':'));
        CCDT_CHECK(name.size() < line.size() && name.find_first_of(" \t") == std::string_view::npos);
        for (const auto* framing : {"Content-Length", "Transfer-Encoding", "Host"})
            CCDT_CHECK(!server::equals_ignoring_case(name, framing));
    }
    CCDT_CHECK(bytes.empty());
}

/// Checks that the bytes of a request can be interpreted in one way only.
/// @param bytes  the whole request as received
void check_lines(std::string_view bytes, std::string_view body) {
    bool chunked = false;
    for (auto line = take_strict_line(bytes); !line.empty(); line = take_strict_line(bytes)) {
        auto value = line;
        chunked = chunked || server::equals_ignoring_case(api::take_until(value, ":"), "Transfer-Encoding");
    }
    if (chunked) return check_chunks(bytes, body);
    CCDT_CHECK(bytes == body);
}

Outcome read_request(Connection& connection) {
    const auto head = connection.read_head();
    if (!head) {
        check_problem(head.error());
        return {head.error().status, {}, {}};
    }
    if (!head->is_framed()) return {200, head->target, {}};
    const auto body = server::test::read_body(connection, *head, kMaxBody);
    if (!body) {
        check_problem(body.error());
        return {body.error().status, head->target, {}};
    }
    CCDT_CHECK(body->size() <= kMaxBody);
    CCDT_CHECK(head->chunked || body->size() == head->content_length);
    return {200, head->target, *body};
}

/// Reads requests that arrive in given pieces, up to the first malformed request.
std::vector<Outcome> serve(const std::vector<std::string_view>& pieces) {
    Wire wire;
    std::string unread;
    for (const auto piece : pieces) {
        wire.send(piece);
        unread += piece;
    }
    wire.hang_up();
    Connection connection(wire.server());
    std::vector<Outcome> outcomes;
    while (connection.wait_for_request([](auto) { return true; })) {
        outcomes.push_back(read_request(connection));
        for (const auto& answer : wire.receive()) CCDT_CHECK(answer == "HTTP/1.1 100 Continue\r\n\r\n");
        CCDT_CHECK(connection.between_requests() == (outcomes.back().status == 200));
        if (!connection.between_requests()) return outcomes;
        while (unread.starts_with("\r\n")) unread.erase(0, 2);
        CCDT_CHECK(connection.bytes_in() <= unread.size());
        check_lines(std::string_view(unread).substr(0, connection.bytes_in()), outcomes.back().body);
        unread.erase(0, connection.bytes_in());
    }
    outcomes.push_back({kUntilItCloses, {}, {}});
    return outcomes;
}

/// Divides bytes into pieces that are not empty.
/// @param lengths  one byte for the length of each piece except the last; above 192, in steps of 64
std::vector<std::string_view> cut(std::string_view bytes, std::string_view lengths) {
    constexpr std::size_t kStepFrom = 192;
    constexpr std::size_t kStep = 64;
    std::vector<std::string_view> pieces;
    for (const char c : lengths) {
        const std::size_t length = static_cast<unsigned char>(c);
        const auto piece = bytes.substr(0, length < kStepFrom ? length : kStepFrom + (length - kStepFrom) * kStep);
        if (!piece.empty()) pieces.push_back(piece);
        bytes.remove_prefix(piece.size());
    }
    if (!bytes.empty()) pieces.push_back(bytes);
    return pieces;
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads requests from a connection, and checks that the result does not depend on how the bytes are divided into
/// pieces. The input has the lengths of the pieces, followed by the bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    auto bytes = text_of(data, size);
    const auto lengths = bytes.substr(0, kMaxPieces - 1);
    bytes.remove_prefix(lengths.size());
    const auto whole = serve(cut(bytes, {}));
    CCDT_CHECK(serve(cut(bytes, lengths)) == whole);
    return 0;
}

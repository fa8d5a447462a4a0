#include "server/http/connection.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using server::Connection;

constexpr std::size_t kLargestBody = 4'096;
constexpr std::size_t kMostPieces = 8;  ///< the system keeps a few more for a reader that has not come yet
constexpr int kUntilItCloses = 0;       ///< status of a connection that ended between two requests

/// What became of one request.
struct Outcome {
    int status = 200;
    std::string target;
    std::string body;

    friend bool operator==(const Outcome&, const Outcome&) = default;
};

/// Two sockets that keep what is sent in one piece together, so that a reader gets it as it was sent.
class Wire {
public:
    Wire() { CCDT_CHECK(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends_.data()) == 0); }
    ~Wire() {
        close(ends_[0]);
        close(ends_[1]);
    }
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;

    int server() const { return ends_[0]; }

    void send(std::string_view piece) {
        const auto sent = ::send(ends_[1], piece.data(), piece.size(), MSG_DONTWAIT);
        CCDT_CHECK(sent == static_cast<ssize_t>(piece.size()));
    }
    void hang_up() { shutdown(ends_[1], SHUT_WR); }

    /// Takes what the server sent, which is nothing but its leave to go on.
    void drain() {
        std::array<char, 64> buffer{};
        while (true) {
            const auto size = recv(ends_[1], buffer.data(), buffer.size(), MSG_DONTWAIT);
            if (size <= 0) return;
            const std::string_view answer(buffer.data(), static_cast<std::size_t>(size));
            CCDT_CHECK(answer == "HTTP/1.1 100 Continue\r\n\r\n");
        }
    }

private:
    std::array<int, 2> ends_{};
};

Outcome read_request(Connection& connection) {
    const auto head = connection.read_head();
    if (!head) {
        check_fault(head.error());
        return {head.error().status, {}, {}};
    }
    if (!head->is_framed()) return {200, head->target, {}};
    const auto body = connection.read_body(*head, kLargestBody);
    if (!body) {
        check_fault(body.error());
        return {body.error().status, head->target, {}};
    }
    CCDT_CHECK(body->size() <= kLargestBody);
    CCDT_CHECK(head->chunked || body->size() == head->content_length);
    return {200, head->target, *body};
}

/// What a server makes of these pieces, up to the request that cannot be read.
std::vector<Outcome> serve(const std::vector<std::string_view>& pieces) {
    Wire wire;
    std::size_t sent = 0;
    for (const auto piece : pieces) {
        wire.send(piece);
        sent += piece.size();
    }
    wire.hang_up();
    Connection connection(wire.server());
    std::vector<Outcome> outcomes;
    std::uint64_t taken = 0;
    while (connection.wait_for_request([](auto) { return true; })) {
        outcomes.push_back(read_request(connection));
        wire.drain();
        taken += connection.bytes_in();
        CCDT_CHECK(taken <= sent);
        CCDT_CHECK(connection.between_requests() == (outcomes.back().status == 200));
        if (!connection.between_requests()) return outcomes;
    }
    outcomes.push_back({kUntilItCloses, {}, {}});
    return outcomes;
}

/// @param lengths  of the pieces but the last, the large ones in steps; none is empty
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

/// Lengths of pieces, and all that a client sends: however it is cut, it is read alike.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    auto bytes = text_of(data, size);
    const auto lengths = bytes.substr(0, kMostPieces - 1);
    bytes.remove_prefix(lengths.size());
    const auto whole = serve(cut(bytes, {}));
    CCDT_CHECK(serve(cut(bytes, lengths)) == whole);
    return 0;
}

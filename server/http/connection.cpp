#include "server/http/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "api/input/text.h"

namespace ccdt::server {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr std::size_t kLargestHead = 32'768;
constexpr std::size_t kLargestLine = 4'096;  ///< of a chunk's size or a trailer
constexpr std::size_t kMostFraming = 8;      ///< bytes of it for one in chunks, beyond a first kLargestHead
constexpr std::size_t kReceiveSize = 16'384;
constexpr std::size_t kFreeBytes = 65'536;      ///< of a body, which are read even if memory is short
constexpr std::size_t kTrustedBytes = 1 << 20;  ///< of a body, after which the length it announces is believed
constexpr std::uint64_t kLeastRate = 32'768;    ///< bytes in a second
constexpr std::uint64_t kLeastRateUnderPressure = 262'144;
constexpr milliseconds kHeadUnderPressure{1'000};
constexpr milliseconds kPauseUnderPressure{2'000};
constexpr milliseconds kLinger{2'000};
constexpr milliseconds kWaitStep{200};  ///< after which a wait looks whether its deadline has moved
constexpr int kNoTime = 0;

/// Waits for an event on the socket, at most until the deadline.
bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline) {
    while (true) {
        const auto left = duration_cast<milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd entry{socket, events, 0};
        const int ready = poll(&entry, 1, static_cast<int>(std::max<milliseconds::rep>(left.count(), 0)));
        if (ready >= 0 || errno != EINTR) return ready > 0;
    }
}

tl::unexpected<Fault> too_large(std::size_t limit) {
    return fault(413, "the body is larger than this server's limit (max-body) of " + std::to_string(limit) + " bytes");
}

/// Size of a chunk; what follows a semicolon is an extension, and ignored.
Received<std::uint64_t> parse_chunk_size(std::string_view line) {
    const auto size = api::parse_number<std::uint64_t>(api::take_until(line, ";"), 16);
    if (!size) return fault(400, "a chunk's size is malformed");
    return *size;
}

}  // namespace

Connection::Connection(int socket, const Patience& patience, Capacity* capacity)
    : socket_(socket), patience_(patience), capacity_(capacity), peer_(peer_of(socket)) {}

bool Connection::wait_for_request(const std::function<bool(Milliseconds waited)>& give_up) {
    bytes_in_ = 0;
    bytes_out_ = 0;
    const auto start = Clock::now();
    while (unread_.empty()) {
        const auto soon = [] { return Clock::now() + kWaitStep; };
        if (wait_for(socket_, POLLIN, soon())) return fill(soon).has_value();
        if (give_up(duration_cast<Milliseconds>(Clock::now() - start))) return false;
    }
    return true;
}

Received<Request> Connection::read_head() {
    const auto start = Clock::now();
    const auto deadline = [&] {
        return start + (is_pressed() ? std::min(patience_.header, kHeadUnderPressure) : patience_.header);
    };
    between_requests_ = false;
    std::size_t end = std::string::npos;
    while (true) {
        // Clients may send a line end after a body; it is no part of the next head.
        std::size_t blank = 0;
        while (unread_.compare(blank, 2, "\r\n") == 0) blank += 2;
        unread_.erase(0, blank);
        end = unread_.find("\r\n\r\n");
        if (std::min(end, unread_.size()) > kLargestHead)
            return fault(431, "the head of the request is larger than " + std::to_string(kLargestHead) + " bytes");
        if (end != std::string::npos) break;
        if (auto filled = fill(deadline); !filled) return tl::unexpected(filled.error());
    }
    auto request = parse_head(take(end + 4));
    between_requests_ = request && !request->chunked && request->content_length.value_or(0) == 0;
    return request;
}

Received<std::string> Connection::read_body(const Request& request, std::size_t limit) {
    if (!request.is_framed()) return fault(411, "the request has neither Content-Length nor chunks");
    if (request.content_length.value_or(0) > limit) return too_large(limit);
    if (request.expects_continue && unread_.empty() && !write("HTTP/1.1 100 Continue\r\n\r\n"))
        return fault(400, "the client left");
    body_ = {Clock::now(), Clock::now(), 0};
    auto body = request.chunked ? read_chunked(limit) : read_plain(*request.content_length);
    between_requests_ = body.has_value();
    return body;
}

bool Connection::client_gone() const {
    pollfd entry{socket_, POLLRDHUP, 0};
    return poll(&entry, 1, kNoTime) > 0;
}

bool Connection::write(std::string_view bytes) {
    Held held(capacity_);
    held.resize(bytes.size());
    Transfer answer{Clock::now(), Clock::now(), 0};
    while (!bytes.empty() && !too_slow_) {
        const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0 && errno == EINTR) continue;
        if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            too_slow_ = !wait(POLLOUT, [&] { return deadline(answer); });
            continue;
        }
        if (sent <= 0) return false;
        answer.move(static_cast<std::size_t>(sent));
        bytes_out_ += static_cast<std::uint64_t>(sent);
        bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return bytes.empty();
}

void Connection::close_gently() {
    if (too_slow_) {
        const linger at_once{1, 0};
        setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
        return;
    }
    shutdown(socket_, SHUT_WR);
    const auto deadline = Clock::now() + kLinger;
    while (!between_requests_ && fill([deadline] { return deadline; })) unread_.clear();
}

void Connection::Transfer::move(std::size_t more) {
    moved = Clock::now();
    bytes += more;
}

/// When a transfer has taken too long: after a pause, or once its rate has been too low for as long.
Connection::Clock::time_point Connection::deadline(const Transfer& transfer) const {
    const bool pressed = is_pressed();
    const auto pause = pressed ? std::min(patience_.body, kPauseUnderPressure) : patience_.body;
    const auto rate = pressed ? kLeastRateUnderPressure : kLeastRate;
    return std::min(transfer.moved + pause, transfer.begun + pause + milliseconds(transfer.bytes * 1000 / rate));
}

/// Waits for an event on the socket. The deadline may move meanwhile; once it has passed not even an event that is
/// there already counts, or a client that sends byte after byte would never be late.
bool Connection::wait(short events, const Deadline& deadline) const {
    while (true) {
        const auto now = Clock::now();
        const auto until = deadline();
        if (now >= until) return false;
        if (wait_for(socket_, events, std::min(until, now + kWaitStep))) return true;
    }
}

/// Receives what there is, waiting for the first byte of it.
Received<bool> Connection::fill(const Deadline& deadline) {
    if (!wait(POLLIN, deadline)) return fault(408, "the request did not arrive in time");
    std::array<char, kReceiveSize> buffer;
    ssize_t received = -1;
    do received = recv(socket_, buffer.data(), buffer.size(), 0);
    while (received < 0 && errno == EINTR);
    if (received <= 0) return fault(400, "the client closed the connection within its request");
    unread_.append(buffer.data(), static_cast<std::size_t>(received));
    return true;
}

std::string Connection::take(std::size_t size) {
    std::string taken = unread_.substr(0, size);
    unread_.erase(0, size);
    bytes_in_ += taken.size();
    return taken;
}

/// A line of the body's framing, without its end.
Received<std::string> Connection::read_line() {
    while (true) {
        const auto end = unread_.find("\r\n");
        if (std::min(end, unread_.size()) > kLargestLine) return fault(400, "a line of the chunked body is too long");
        if (end != std::string::npos) {
            std::string line = take(end + 2);
            line.resize(end);
            return line;
        }
        if (auto filled = fill([this] { return deadline(body_); }); !filled) return tl::unexpected(filled.error());
    }
}

Received<bool> Connection::append(std::string& body, std::uint64_t size, Held& held) {
    while (size > 0) {
        if (unread_.empty()) {
            if (auto filled = fill([this] { return deadline(body_); }); !filled) return filled;
        }
        const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(size, unread_.size()));
        body.append(unread_, 0, part);
        unread_.erase(0, part);
        size -= part;
        bytes_in_ += part;
        body_.move(part);
        held.resize(body.size());
        if (body.size() > kFreeBytes && capacity_ != nullptr && capacity_->is_out_of_memory())
            return fault(503, "too many bodies are being sent at once", {{"Retry-After", "1"}});
        if (body.size() > kTrustedBytes) body.reserve(body.size() + size);
    }
    return true;
}

Received<std::string> Connection::read_plain(std::uint64_t size) {
    std::string body;
    Held held(capacity_);
    if (auto read = append(body, size, held); !read) return tl::unexpected(read.error());
    return body;
}

Received<std::string> Connection::read_chunked(std::size_t limit) {
    std::string body;
    Held held(capacity_);
    const auto before = bytes_in_;
    while (true) {
        const auto size = read_line().and_then(parse_chunk_size);
        if (!size) return tl::unexpected(size.error());
        if (*size == 0) break;
        if (*size > limit - body.size()) return too_large(limit);
        if (auto read = append(body, *size, held); !read) return tl::unexpected(read.error());
        const auto end = read_line();
        if (!end) return tl::unexpected(end.error());
        if (!end->empty()) return fault(400, "a chunk is longer than its size");
        if (bytes_in_ - before > body.size() * (1 + kMostFraming) + kLargestHead)
            return fault(400, "the chunks are small for their framing");
    }
    if (auto skipped = skip_trailers(); !skipped) return tl::unexpected(skipped.error());
    return body;
}

/// Nothing here uses trailers, and few of them are enough.
Received<bool> Connection::skip_trailers() {
    for (std::size_t skipped = 0; skipped <= kLargestLine;) {
        const auto line = read_line();
        if (!line) return tl::unexpected(line.error());
        if (line->empty()) return true;
        skipped += line->size();
    }
    return fault(400, "the trailers of the chunked body are too long");
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "server/http/proxy_protocol.h"

namespace ccdt::server {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr std::size_t kLargestHead = 32'768;
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kLongestLine = 4'096;  ///< limit for a line with a chunk size or a trailer
constexpr std::size_t kMaxFraming = 8;       ///< permitted framing bytes per body byte, in addition to kLargestHead
constexpr std::size_t kReceiveSize = 16'384;
constexpr std::size_t kFreeBytes = 65'536;  ///< bytes of a body that are read even if memory is short
/// Number of received bytes of a body above which its Content-Length is trusted, and memory for the whole body is
/// reserved.
constexpr std::size_t kTrustedBytes = 1 << 20;
constexpr std::uint64_t kMinRate = 32'768;  ///< bytes per second
constexpr std::uint64_t kMinRateUnderPressure = 262'144;
constexpr milliseconds kHeadUnderPressure{1'000};
constexpr milliseconds kPauseUnderPressure{2'000};
constexpr milliseconds kLinger{2'000};
constexpr milliseconds kWaitStep{200};  ///< interval at which a wait recomputes its deadline
constexpr int kNoTime = 0;

/// Waits for an event on the socket until the deadline.
bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline) {
    while (true) {
        const auto remaining = duration_cast<milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd entry{socket, events, 0};
        const int ready = poll(&entry, 1, static_cast<int>(std::max<milliseconds::rep>(remaining.count(), 0)));
        if (ready >= 0 || errno != EINTR) return ready > 0;
    }
}

tl::unexpected<Problem> too_large(std::size_t limit) {
    return problem(413,
                   "the body is larger than this server's limit (max-body) of " + std::to_string(limit) + " bytes");
}

tl::unexpected<Problem> late() {
    return problem(408, "the request did not arrive in time");
}

bool may_break_a_line(char c) {
    return c == '\r' || c == '\n' || c == '\0';
}

}  // namespace

Connection::Connection(int socket, const Patience& patience, Capacity* capacity, ConnectionSlot* slot)
    : socket_(socket), patience_(patience), capacity_(capacity), slot_(slot), peer_(peer_of(socket)), client_(peer_) {}

bool Connection::wait_for_request(const std::function<bool(Milliseconds waited)>& should_stop) {
    bytes_in_ = 0;
    bytes_out_ = 0;
    if (!unread_.empty()) return true;
    return wait_for_bytes(should_stop) && fill([] { return Clock::now() + kWaitStep; });
}

HttpResult<void> Connection::read_proxy_header() {
    between_requests_ = false;
    const Fill fill_up = fill_head();
    while (true) {
        auto header = parse_proxy_header(unread_.view());
        if (!header) return tl::unexpected(std::move(header.error()));
        if (header->state != ProxyHeader::State::Partial) {
            unread_.use(header->size);
            if (header->client) client_ = peer_ = *std::move(header->client);
            between_requests_ = true;
            return {};
        }
        if (auto filled = fill_up(); !filled) return filled;
    }
}

HttpResult<Request> Connection::read_head() {
    ++heads_;
    between_requests_ = false;
    client_ = peer_;
    const Fill fill_up = fill_head();
    std::size_t end = 0;
    for (bool blank = false; !blank;) {
        const auto line_end = find_line_end(end, kLargestHead, fill_up);
        if (!line_end) return tl::unexpected(line_end.error());
        if (*line_end == std::string_view::npos)
            return problem(431, "the head of the request is larger than " + std::to_string(kLargestHead) + " bytes");
        if (*line_end == 0) {
            // Clients may send a line end after a body. This line end is not part of the next head.
            unread_.use(kLineEnd.size());
            continue;
        }
        blank = *line_end == end;
        end = *line_end + kLineEnd.size();
    }
    auto request = parse_head(use(end));
    between_requests_ = request && !request->chunked && request->content_length.value_or(0) == 0;
    return request;
}

HttpResult<std::string> Connection::read_body(const Request& request, std::size_t limit) {
    if (!request.is_framed()) return problem(411, "the request has neither Content-Length nor chunks");
    if (request.content_length.value_or(0) > limit) return too_large(limit);
    if (request.expects_continue && unread_.empty() && !write("HTTP/1.1 100 Continue\r\n\r\n"))
        return problem(400, "the client closed the connection");
    const auto announced = request.content_length.value_or(0);
    body_.emplace(capacity_, request.chunked, announced, limit, bytes_in_);
    std::string body;
    const Receive receive = [&](std::string_view piece) {
        if (body.size() > kTrustedBytes && body.capacity() < announced) body.reserve(announced);
        body += piece;
        return true;
    };
    const bool decoded = decode_ && decode_(receive);
    const auto outcome = std::move(body_->outcome);
    between_requests_ = decoded && outcome && body_->is_complete();
    body_.reset();
    if (!outcome) return tl::unexpected(outcome.error());
    if (!between_requests_) return problem(500, "cpp-httplib did not read the whole body");
    return body;
}

ssize_t Connection::read_content(char* target, std::size_t size) {
    if (!body_ || !body_->outcome) return -1;
    const auto passed = pass_on(target, size);
    if (passed) return static_cast<ssize_t>(*passed);
    body_->outcome = tl::unexpected(passed.error());
    return -1;
}

bool Connection::client_gone() const {
    pollfd entry{socket_, POLLRDHUP, 0};
    return poll(&entry, 1, kNoTime) > 0;
}

bool Connection::write(std::string_view bytes) {
    CountedBytes held(capacity_);
    held.resize(bytes.size());
    Transfer answer;
    while (!bytes.empty() && !too_slow_) {
        const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0 && errno == EINTR) continue;
        if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            too_slow_ = !wait(POLLOUT, [&] { return deadline(answer); });
            continue;
        }
        if (sent <= 0) return false;
        answer.move_to(answer.bytes + static_cast<std::uint64_t>(sent));
        bytes_out_ += static_cast<std::uint64_t>(sent);
        bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return bytes.empty();
}

void Connection::close_gently() {
    if (too_slow_ || resets_) {
        const linger at_once{1, 0};
        setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
        return;
    }
    shutdown(socket_, SHUT_WR);
    const IdleTime idle(slot_, socket_);
    const auto deadline = Clock::now() + kLinger;
    while (!between_requests_ && fill([deadline] { return deadline; })) unread_.use(unread_.view().size());
}

void Connection::Unread::add(std::string_view more) {
    bytes_.erase(0, std::exchange(used_, 0));
    bytes_ += more;
}

void Connection::Transfer::move_to(std::uint64_t total) {
    if (total == bytes) return;
    moved = Clock::now();
    bytes = total;
}

/// Waits until a byte arrives or the client closes the connection. Marks the connection as idle during the wait.
/// @returns  false if `should_stop` returned true
bool Connection::wait_for_bytes(const std::function<bool(Milliseconds waited)>& should_stop) const {
    const IdleTime idle(slot_, socket_);
    const auto start = Clock::now();
    while (!wait_for(socket_, POLLIN, Clock::now() + kWaitStep)) {
        if (should_stop(duration_cast<Milliseconds>(Clock::now() - start))) return false;
    }
    return true;
}

/// Computes the deadline of a transfer. The deadline is one maximum pause after the earlier of two times: the latest
/// progress, and the time at which the minimum rate would have transferred the same bytes.
Connection::Clock::time_point Connection::deadline(const Transfer& transfer) const {
    const bool pressed = is_pressed();
    const auto pause = pressed ? std::min(patience_.body, kPauseUnderPressure) : patience_.body;
    const auto rate = pressed ? kMinRateUnderPressure : kMinRate;
    return std::min(transfer.moved + pause, transfer.begun + pause + milliseconds(transfer.bytes * 1000 / rate));
}

/// Waits for an event on the socket. The deadline may move during the wait. Returns false after the deadline, even if
/// an event has occurred, so that a client that sends one byte at a time cannot exceed the deadline.
bool Connection::wait(short events, const Deadline& deadline) const {
    while (true) {
        const auto now = Clock::now();
        const auto until = deadline();
        if (now >= until) return false;
        if (wait_for(socket_, events, std::min(until, now + kWaitStep))) return true;
    }
}

/// Waits until a byte arrives, then receives the available bytes.
HttpResult<void> Connection::fill(const Deadline& deadline) {
    if (!wait(POLLIN, deadline)) return late();
    std::array<char, kReceiveSize> buffer;
    ssize_t received = -1;
    do received = recv(socket_, buffer.data(), buffer.size(), 0);
    while (received < 0 && errno == EINTR);
    if (received <= 0) return problem(400, "the client closed the connection within its request");
    unread_.add({buffer.data(), static_cast<std::size_t>(received)});
    return {};
}

/// Returns a function that receives more bytes of a head whose first byte has arrived. While the function waits, the
/// connection may be closed in favour of a new one. The client then gets a 408.
Connection::Fill Connection::fill_head() {
    const auto start = Clock::now();
    const auto deadline = [this, start] {
        return start + (is_pressed() ? std::min(patience_.header, kHeadUnderPressure) : patience_.header);
    };
    return [this, start, deadline] {
        const IdleTime idle(slot_, socket_, start);
        auto filled = fill(deadline);
        if (slot_ != nullptr && slot_->is_closed()) return HttpResult<void>(late());
        return filled;
    };
}

/// Receives more of the body. Fails if the bodies of all connections take too much memory.
HttpResult<void> Connection::fill_body() {
    const auto passed = body_->progress.bytes;
    body_->held.resize(passed);
    if (passed > kFreeBytes && capacity_ != nullptr && capacity_->is_out_of_memory())
        return busy(503, "too many bodies are being sent at once", std::chrono::seconds(1));
    return fill([this] { return deadline(body_->progress); });
}

/// Consumes the next `size` received bytes.
/// @returns  the consumed bytes; valid until more are received
std::string_view Connection::use(std::size_t size) {
    const auto used = unread_.view().substr(0, size);
    unread_.use(size);
    bytes_in_ += size;
    return used;
}

/// Looks for the end of a line in the received bytes, and receives more bytes until the end has arrived.
/// @param begin  start of the line
/// @param limit  last permitted position of the CRLF
/// @returns      position of the CRLF; npos: beyond the limit
/// Problems, in addition to the problems of `fill_up`: 400 if the line contains a NUL, or a CR or LF outside a CRLF.
/// Other programs might take these for the end of a line.
HttpResult<std::size_t> Connection::find_line_end(std::size_t begin, std::size_t limit, const Fill& fill_up) {
    for (std::size_t at = begin;;) {
        const auto received = unread_.view();
        while (at < received.size() && at <= limit && !may_break_a_line(received[at])) ++at;
        if (at > limit) return std::string_view::npos;
        const auto found = received.substr(at, kLineEnd.size());
        if (found == kLineEnd) return at;
        if (!kLineEnd.starts_with(found)) return problem(400, "a line does not end in CRLF, or contains a NUL");
        if (auto filled = fill_up(); !filled) return tl::unexpected(filled.error());
    }
}

/// Reads a line of the body's framing, without its CRLF. The view is valid until more bytes are received.
HttpResult<std::string_view> Connection::read_line() {
    const auto end = find_line_end(0, kLongestLine, [this] { return fill_body(); });
    if (!end) return tl::unexpected(end.error());
    if (*end == std::string_view::npos) return problem(400, "a line of the chunked body is too long");
    return use(*end + kLineEnd.size()).substr(0, *end);
}

/// Copies the next bytes of the body, framing or content, to `target`. If received bytes are left, does not wait, count
/// memory or check the clock, which would be slow for many small chunks.
HttpResult<std::size_t> Connection::pass_on(char* target, std::size_t size) {
    Body& body = *body_;
    if (body.is_complete()) return 0;
    if (body.framing.empty() && body.remaining == 0) {
        if (auto begun = begin_chunk(); !begun) return tl::unexpected(begun.error());
    }
    if (!body.framing.empty()) {
        const auto count = body.framing.copy(target, size);
        body.framing.erase(0, count);
        return count;
    }
    if (unread_.empty()) {
        if (auto filled = fill_body(); !filled) return tl::unexpected(filled.error());
    }
    const auto part = use(std::min<std::uint64_t>({size, body.remaining, unread_.view().size()}));
    body.remaining -= part.size();
    body.progress.move_to(body.progress.bytes + part.size());
    return part.copy(target, size);
}

/// Reads the line end of the previous chunk and the size of the next one. Skips trailers after the last chunk.
HttpResult<void> Connection::begin_chunk() {
    Body& body = *body_;
    const auto passed = body.progress.bytes;
    if (passed > 0) {
        const auto end = find_line_end(0, 0, [this] { return fill_body(); });
        if (!end) return tl::unexpected(end.error());
        if (*end != 0) return problem(400, "a chunk is longer than its size");
        use(kLineEnd.size());
        body.framing = kLineEnd;
        if (bytes_in_ - body.begin > passed * (1 + kMaxFraming) + kLargestHead)
            return problem(400, "the chunks are too small for their framing");
    }
    const auto size = read_line().and_then(parse_chunk_size);
    if (!size) return tl::unexpected(size.error());
    if (*size > body.limit - passed) return too_large(body.limit);
    if (*size == 0) {
        if (auto skipped = skip_trailers(); !skipped) return skipped;
    }
    char line[20];
    body.framing.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof(line), "%zx\r\n", *size)));
    if (*size == 0) body.framing += kLineEnd;
    body.remaining = *size;
    body.at_end = *size == 0;
    return {};
}

/// Skips trailers, which are not used. Their total length is limited.
HttpResult<void> Connection::skip_trailers() {
    for (std::size_t skipped = 0; skipped <= kLongestLine;) {
        const auto line = read_line();
        if (!line) return tl::unexpected(line.error());
        if (line->empty()) return {};
        if (auto checked = check_trailer(*line); !checked) return checked;
        skipped += line->size();
    }
    return problem(400, "the trailers of the chunked body are too long");
}

}  // namespace ccdt::server

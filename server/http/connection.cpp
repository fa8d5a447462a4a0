// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "server/http/proxy_protocol.h"

namespace ccdt::server {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr std::size_t kLargestHead = 32'768;
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kLongestLine = 4'096;  ///< limit for a line with a chunk's size or a trailer
constexpr std::size_t kMaxFraming = 8;       ///< maximum of framing bytes per body byte, beyond the first kLargestHead
constexpr std::size_t kReceiveSize = 16'384;
constexpr std::size_t kFreeBytes = 65'536;      ///< bytes of a body that are read even if memory is short
constexpr std::size_t kTrustedBytes = 1 << 20;  ///< bytes of a body after which its announced length is trusted
constexpr std::uint64_t kLeastRate = 32'768;    ///< bytes per second
constexpr std::uint64_t kLeastRateUnderPressure = 262'144;
constexpr milliseconds kHeadUnderPressure{1'000};
constexpr milliseconds kPauseUnderPressure{2'000};
constexpr milliseconds kLinger{2'000};
constexpr milliseconds kWaitStep{200};  ///< interval at which a wait checks whether its deadline has moved
constexpr int kNoTime = 0;

/// Waits for an event on the socket until the deadline.
bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline) {
    while (true) {
        const auto left = duration_cast<milliseconds>(deadline - std::chrono::steady_clock::now());
        pollfd entry{socket, events, 0};
        const int ready = poll(&entry, 1, static_cast<int>(std::max<milliseconds::rep>(left.count(), 0)));
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
            // Clients may send a line end after a body. It is not part of the next head.
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
    CountedBytes held(capacity_);
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

/// Waits for the first byte or the end of a connection, which counts as idle meanwhile.
/// @returns  false if `should_stop` returned true
bool Connection::wait_for_bytes(const std::function<bool(Milliseconds waited)>& should_stop) const {
    const IdleTime idle(slot_, socket_);
    const auto start = Clock::now();
    while (!wait_for(socket_, POLLIN, Clock::now() + kWaitStep)) {
        if (should_stop(duration_cast<Milliseconds>(Clock::now() - start))) return false;
    }
    return true;
}

/// Computes the deadline of a transfer: one pause after its latest progress or, if that is earlier, one pause after the
/// time by which the minimum rate would have carried its bytes.
Connection::Clock::time_point Connection::deadline(const Transfer& transfer) const {
    const bool pressed = is_pressed();
    const auto pause = pressed ? std::min(patience_.body, kPauseUnderPressure) : patience_.body;
    const auto rate = pressed ? kLeastRateUnderPressure : kLeastRate;
    return std::min(transfer.moved + pause, transfer.begun + pause + milliseconds(transfer.bytes * 1000 / rate));
}

/// Waits for an event on the socket. The deadline may move during the wait. After the deadline, the result is false
/// even if an event has already occurred; otherwise a client that sends one byte at a time would never be late.
bool Connection::wait(short events, const Deadline& deadline) const {
    while (true) {
        const auto now = Clock::now();
        const auto until = deadline();
        if (now >= until) return false;
        if (wait_for(socket_, events, std::min(until, now + kWaitStep))) return true;
    }
}

/// Waits for the first byte, then receives all available bytes.
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

/// Makes the function that receives more of a head, whose first byte has arrived. While it waits, the connection may be
/// closed for a new one; the client is then told that it was too slow.
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

/// Receives more of a body. `body` is the part that has arrived.
HttpResult<void> Connection::fill(const std::string& body, CountedBytes& held) {
    body_.move_to(body.size());
    held.resize(body.size());
    if (body.size() > kFreeBytes && capacity_ != nullptr && capacity_->is_out_of_memory())
        return busy(503, "too many bodies are being sent at once", std::chrono::seconds(1));
    return fill([this] { return deadline(body_); });
}

/// Consumes received bytes.
/// @returns  these bytes, valid until more are received
std::string_view Connection::use(std::size_t size) {
    const auto used = unread_.view().substr(0, size);
    unread_.use(size);
    bytes_in_ += size;
    return used;
}

/// Looks for the end of a line in the received bytes, and receives more bytes until the end has arrived.
/// @param begin  start of the line
/// @param limit  last position that its CRLF may have
/// @returns      position of the CRLF; npos: beyond the limit
/// Problems, in addition to those of receiving: 400 if the line contains a NUL, or a CR or LF outside a CRLF. Other
/// programs might take these for the end of a line.
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
HttpResult<std::string_view> Connection::read_line(const Fill& fill_up) {
    const auto end = find_line_end(0, kLongestLine, fill_up);
    if (!end) return tl::unexpected(end.error());
    if (*end == std::string_view::npos) return problem(400, "a line of the chunked body is too long");
    return use(*end + kLineEnd.size()).substr(0, *end);
}

HttpResult<void> Connection::append(std::string& body, std::uint64_t size, const Fill& fill_up) {
    while (size > 0) {
        if (unread_.empty()) {
            if (body.size() > kTrustedBytes) body.reserve(body.size() + size);
            if (auto filled = fill_up(); !filled) return filled;
        }
        const auto part = use(std::min<std::uint64_t>(size, unread_.view().size()));
        body += part;
        size -= part.size();
    }
    return {};
}

HttpResult<std::string> Connection::read_plain(std::uint64_t size) {
    std::string body;
    CountedBytes held(capacity_);
    if (auto read = append(body, size, [&] { return fill(body, held); }); !read) return tl::unexpected(read.error());
    return body;
}

/// Reads chunks. Chunks that have arrived already are read without waiting, counting memory or checking the clock,
/// because chunks may be small.
HttpResult<std::string> Connection::read_chunked(std::size_t limit) {
    std::string body;
    CountedBytes held(capacity_);
    const Fill fill_up = [&] { return fill(body, held); };
    const auto before = bytes_in_;
    while (true) {
        const auto size = read_line(fill_up).and_then(parse_chunk_size);
        if (!size) return tl::unexpected(size.error());
        if (*size == 0) break;
        if (*size > limit - body.size()) return too_large(limit);
        const auto read = append(body, *size, fill_up).and_then([&] { return skip_chunk_end(fill_up); });
        if (!read) return tl::unexpected(read.error());
        if (bytes_in_ - before > body.size() * (1 + kMaxFraming) + kLargestHead)
            return problem(400, "the chunks are too small for their framing");
    }
    if (auto skipped = skip_trailers(fill_up); !skipped) return tl::unexpected(skipped.error());
    return body;
}

HttpResult<void> Connection::skip_chunk_end(const Fill& fill_up) {
    while (true) {
        const auto found = unread_.view().substr(0, kLineEnd.size());
        if (!kLineEnd.starts_with(found)) return problem(400, "a chunk is longer than its size");
        if (found == kLineEnd) break;
        if (auto filled = fill_up(); !filled) return filled;
    }
    use(kLineEnd.size());
    return {};
}

/// Skips trailers, which are not used. Their total length is limited.
HttpResult<void> Connection::skip_trailers(const Fill& fill_up) {
    for (std::size_t skipped = 0; skipped <= kLongestLine;) {
        const auto line = read_line(fill_up);
        if (!line) return tl::unexpected(line.error());
        if (line->empty()) return {};
        if (auto checked = check_trailer(*line); !checked) return checked;
        skipped += line->size();
    }
    return problem(400, "the trailers of the chunked body are too long");
}

}  // namespace ccdt::server

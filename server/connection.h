#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "server/http.h"

namespace ccdt::server {

/// One client's socket, with what was read from it and not yet used.
///
/// Belongs to the thread that serves the client. Requests are read one after another: the head, then, if whoever
/// answers wants it, the body. A body that was not read to its end leaves the connection unusable: its bytes must
/// never be taken for the next request.
class Connection {
public:
    using Milliseconds = std::chrono::milliseconds;

    /// Does not own the socket.
    explicit Connection(int socket);

    /// Waits for the first byte of the next request.
    /// @param give_up  asked about ten times a second with the time waited so far
    /// @returns        false if the client closed the connection or the wait was given up
    bool wait_for_request(const std::function<bool(Milliseconds waited)>& give_up);

    /// Faults: 400 malformed, 408 too slow, 431 too large. The connection is then unusable.
    Received<Request> read_head();

    /// Reads the body that `request`, the last head read, announces; at most once for each head.
    ///
    /// Tells a client that waits for it to go ahead. Faults: 400 malformed, 408 too slow, 411 not announced, 413 more
    /// bytes than the limit, at once if the head says so.
    Received<std::string> read_body(const Request& request, std::size_t limit);

    /// All of the last request was read: the next byte begins another.
    bool between_requests() const { return between_requests_; }

    /// The client closed its side. Half-closed counts: browsers and proxies close both.
    bool client_gone() const;

    /// False if the client takes nothing any more.
    bool write(std::string_view bytes);

    /// Closes our side. If bytes of the client were left unread, the rest of them is thrown away for a while: closing
    /// with unread bytes resets the connection, and the client would lose the answer.
    void close_gently();

    /// Address and port of the client, for the log.
    const std::string& client() const { return client_; }

    /// Without the port.
    std::string client_address() const { return client_.substr(0, client_.rfind(':')); }

    std::uint64_t bytes_in() const { return bytes_in_; }  ///< of the current request
    std::uint64_t bytes_out() const { return bytes_out_; }

private:
    using Clock = std::chrono::steady_clock;

    Received<bool> fill(Clock::time_point deadline);
    Received<std::string> read_line();
    Received<bool> append(std::string& body, std::uint64_t size);
    Received<std::string> read_plain(std::uint64_t size);
    Received<std::string> read_chunked(std::size_t limit);
    Received<bool> skip_trailers();
    std::string take(std::size_t size);

    const int socket_;
    const std::string client_;
    std::string unread_;  ///< received, not yet used
    bool between_requests_ = true;
    std::uint64_t bytes_in_ = 0;
    std::uint64_t bytes_out_ = 0;
};

}  // namespace ccdt::server

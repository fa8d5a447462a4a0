// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/capacity.h"
#include "server/http/http.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// Time-outs of a client. They are shorter while Capacity::is_pressed() or the server shuts down.
struct Patience {
    std::chrono::milliseconds header{10'000};  ///< limit for the whole head of a request
    /// Maximum pause within a transfer. Also the maximum lag behind a transfer at the minimum rate of 32 KiB/s.
    std::chrono::milliseconds body{30'000};
    std::chrono::milliseconds idle{60'000};  ///< limit between two requests; also the time-out of idle threads
};

/// A client's socket and the received bytes that are not processed yet.
///
/// Belongs to the thread that serves the client. Requests are read one after another: the head, then, if the handler
/// asks for it, the body. If a body was not read to its end, no further request is read, because the rest of the body
/// must never be parsed as a request. No wait exceeds the time-outs, whatever the client does.
class Connection {
public:
    using Milliseconds = std::chrono::milliseconds;

    /// Does not own the socket. `capacity` and `slot`, if not null, must outlive the connection.
    explicit Connection(int socket, const Patience& patience = {}, Capacity* capacity = nullptr,
                        ConnectionSlot* slot = nullptr);

    /// Waits for the first byte of the next request.
    /// @param should_stop  called about five times a second with the time waited so far
    /// @returns            false if the client closed the connection, or `should_stop` returned true
    bool wait_for_request(const std::function<bool(Milliseconds waited)>& should_stop);

    /// Reads the PROXY header at the start of a connection, if there is one. The client that it names becomes the peer.
    /// The first byte must have arrived.
    /// Problems: 400 malformed, 408 too slow. Afterwards the connection is unusable.
    HttpResult<void> read_proxy_header();

    /// Reads the head of a request.
    /// Problems: 400 malformed, 408 too slow, 431 too large. Afterwards the connection is unusable.
    HttpResult<Request> read_head();

    /// Takes a piece of a body; returns false to stop.
    using Receive = std::function<bool(std::string_view piece)>;
    /// Decodes a body from read_content(), and passes the pieces to `receive`. Returns false on failure.
    using Decode = std::function<bool(const Receive& receive)>;

    /// Sets the function that decodes the body of the current request; null: the body cannot be read.
    void decode_with(Decode decode) { decode_ = std::move(decode); }

    /// Reads the body of `request`, which must be the result of the last read_head(). May be called once for each head.
    ///
    /// Sends 100 Continue to a client that waits for it. Requires decode_with().
    /// Problems: 400 malformed, 408 too slow, 411 no length, 413 larger than `limit` (checked before reading if the
    /// head gives the length), 503 the bodies of all connections take too much memory.
    HttpResult<std::string> read_body(const Request& request, std::size_t limit);

    /// Copies the next bytes of the body that read_body() is reading, for the decoder. Chunked bodies stay chunked, but
    /// without extensions and trailers. Every line between chunks has been checked.
    /// @returns  number of bytes; 0: the body has ended; -1: a problem, or read_body() is not running
    ssize_t read_content(char* target, std::size_t size);

    const Patience& patience() const { return patience_; }

    /// Whether the current request is the connection's first.
    bool is_on_first_request() const { return heads_ <= 1; }

    /// Whether the last request was read completely, so that the next byte begins another request.
    bool between_requests() const { return between_requests_; }

    /// Whether the client has closed its sending side. Such a client counts as gone, because browsers and proxies close
    /// both directions at once.
    bool client_gone() const;

    /// Sends bytes; returns false if the client has closed the connection or receives too slowly.
    bool write(std::string_view bytes);

    /// Closes the server's side. Reads and discards unread bytes of the client for up to 2 s, because closing a socket
    /// with unread bytes resets the connection, and the client would lose the answer. If the client received its answer
    /// too slowly, the connection is reset instead, which frees the unsent bytes in the kernel.
    void close_gently();

    /// Makes close_gently() reset the connection, so that the client does not mistake a partial answer for a whole one.
    void reset() { resets_ = true; }

    /// Moves the connection's slot to the class that the current request needs; returns false if that class is full.
    bool move_to(ConnectionClass connection_class) { return slot_ == nullptr || slot_->move_to(connection_class); }

    /// Whether the connection has a reserve slot. Such connections are closed after their first request.
    bool in_reserve() const { return slot_ != nullptr && slot_->connection_class() == ConnectionClass::Reserve; }

    /// Returns the client or proxy that connected.
    const Peer& peer() const { return peer_; }

    /// Returns the sender of the current request: the peer or, if the peer is a trusted proxy, the client that the
    /// proxy names.
    const Peer& client() const { return client_; }
    void set_client(Peer client) { client_ = std::move(client); }

    /// Returns the name of the sender for fair queueing: the name set by name_client(), or else the address.
    const std::string& client_name() const { return client_name_.empty() ? client_.address : client_name_; }
    void name_client(std::string name, std::string key) {
        client_name_ = std::move(name);
        key_ = std::move(key);
    }

    /// Returns the name of the API key of the current request; empty: none.
    const std::string& key() const { return key_; }

    std::uint64_t bytes_in() const { return bytes_in_; }  ///< bytes received for the current request
    std::uint64_t bytes_out() const { return bytes_out_; }

private:
    using Clock = std::chrono::steady_clock;
    using Deadline = std::function<Clock::time_point()>;
    using Fill = std::function<HttpResult<void>()>;

    /// Received bytes that are consumed from the front.
    class Unread {
    public:
        bool empty() const { return used_ == bytes_.size(); }
        std::string_view view() const { return std::string_view(bytes_).substr(used_); }
        void use(std::size_t size) { used_ += size; }
        void add(std::string_view more);

    private:
        std::string bytes_;
        std::size_t used_ = 0;
    };

    /// The progress of a body or an answer, from which its deadline is computed.
    struct Transfer {
        Clock::time_point begun = Clock::now();
        Clock::time_point moved = begun;  ///< time of the latest progress
        std::uint64_t bytes = 0;

        void move_to(std::uint64_t total);
    };

    /// A body that is being read.
    struct Body {
        Body(Capacity* capacity, bool chunked, std::uint64_t size, std::size_t max_size, std::uint64_t first)
            : limit(max_size), begin(first), remaining(size), at_end(!chunked), held(capacity) {}

        const std::size_t limit;    ///< maximum size of the body
        const std::uint64_t begin;  ///< position of the body's first byte within the request [bytes]
        std::uint64_t
            remaining;        ///< bytes of the body, or of its current chunk, that read_content() has not returned yet
        bool at_end;          ///< no chunk follows the bytes that `remaining` counts
        std::string framing;  ///< chunk line or line end that read_content() returns before the next content
        Transfer progress;    ///< counts the returned content, without framing
        CountedBytes held;
        HttpResult<void> outcome;

        bool is_complete() const { return framing.empty() && remaining == 0 && at_end; }
    };

    bool is_pressed() const { return capacity_ != nullptr && (capacity_->is_pressed() || capacity_->is_closing()); }
    bool wait_for_bytes(const std::function<bool(Milliseconds waited)>& should_stop) const;
    Clock::time_point deadline(const Transfer& transfer) const;
    bool wait(short events, const Deadline& deadline) const;
    HttpResult<void> fill(const Deadline& deadline);
    Fill fill_head();
    HttpResult<void> fill_body();
    HttpResult<std::size_t> find_line_end(std::size_t begin, std::size_t limit, const Fill& fill_up);
    HttpResult<std::string_view> read_line();
    HttpResult<std::size_t> pass_on(char* target, std::size_t size);
    HttpResult<void> begin_chunk();
    HttpResult<void> skip_trailers();
    std::string_view use(std::size_t size);

    const int socket_;
    const Patience patience_;
    Capacity* const capacity_;
    ConnectionSlot* const slot_;
    Peer peer_;
    Peer client_;
    std::string client_name_;
    std::string key_;
    Unread unread_;
    Decode decode_;
    std::optional<Body> body_;  ///< the body that read_body() is reading
    std::uint64_t heads_ = 0;   ///< number of heads read, including malformed ones
    bool between_requests_ = true;
    bool too_slow_ = false;  ///< the client received an answer too slowly
    bool resets_ = false;
    std::uint64_t bytes_in_ = 0;
    std::uint64_t bytes_out_ = 0;
};

}  // namespace ccdt::server

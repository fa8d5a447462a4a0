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

/// Time-outs of a client. Under pressure they are shorter: see Capacity.
struct Patience {
    std::chrono::milliseconds header{10'000};  ///< for the whole head of a request
    /// Longest pause within a body or an answer. Also the time that a transfer may take in excess of its size divided
    /// by the minimum rate, 32 KiB/s.
    std::chrono::milliseconds body{30'000};
    std::chrono::milliseconds idle{
        60'000};  ///< between two requests; also the time that an idle thread waits for another connection
};

/// A client's socket, and the bytes received from it that are not processed yet.
///
/// Belongs to the thread that serves the client. Requests are read one after another: the head, then, if the handler
/// asks for it, the body. If a body was not read to its end, no further request is read, because the rest of the body
/// must never be taken for a request. Whatever the client sends or receives, no wait exceeds its time-outs.
class Connection {
public:
    using Milliseconds = std::chrono::milliseconds;

    /// Does not own the socket. `capacity` and `slot`, if not null, must outlive the connection.
    explicit Connection(int socket, const Patience& patience = {}, Capacity* capacity = nullptr,
                        ConnectionSlot* slot = nullptr);

    /// Waits for the first byte of the next request.
    /// @param should_stop  called about five times a second with the time waited so far
    /// @returns        false if the client closed the connection, or `should_stop` returned true
    bool wait_for_request(const std::function<bool(Milliseconds waited)>& should_stop);

    /// Reads the PROXY header. If there is one, the client that it names becomes the peer. Requires that the first
    /// bytes have arrived.
    /// Problems: 400 malformed, 408 too slow. Afterwards the connection is unusable.
    HttpResult<void> read_proxy_header();

    /// Reads the head of a request.
    /// Problems: 400 malformed, 408 too slow, 431 too large. Afterwards the connection is unusable.
    HttpResult<Request> read_head();

    /// Takes a piece of a body; returns false to stop.
    using Receive = std::function<bool(std::string_view piece)>;
    /// Decodes a body, which it takes from read_content(). Returns false if it failed or was stopped.
    using Decode = std::function<bool(const Receive& receive)>;

    /// Sets the function that decodes the body of the current request; null: the body cannot be read.
    void decode_with(Decode decode) { decode_ = std::move(decode); }

    /// Reads the body of `request`, whose head was the last one read; at most once for each head.
    ///
    /// Sends 100 Continue to a client that waits for it. Requires decode_with().
    /// Problems: 400 malformed, 408 too slow, 411 no length, 413 larger than the limit (at once if the head says so),
    /// 503 all bodies together take too much memory.
    HttpResult<std::string> read_body(const Request& request, std::size_t limit);

    /// Copies the next bytes of the body that read_body() reads. They have the client's framing, plain or in chunks,
    /// but no chunk extensions and no trailers. Every line of the framing has been checked.
    /// @returns  number of bytes, at least 1; 0: the body has ended; -1: there is a problem, or read_body() is not
    ///           running
    ssize_t read_content(char* target, std::size_t size);

    const Patience& patience() const { return patience_; }

    /// Whether the current request is the connection's first.
    bool is_on_first_request() const { return heads_ <= 1; }

    /// Whether the last request was read completely, so that the next byte begins another request.
    bool between_requests() const { return between_requests_; }

    /// Whether the client has closed its sending side. The client then counts as gone even if it might still receive,
    /// because browsers and proxies close both directions at once.
    bool client_gone() const;

    /// Sends bytes; returns false if the client has closed the connection or receives too slowly.
    bool write(std::string_view bytes);

    /// Closes our side. If the client has sent bytes that are unread, they are read and discarded for a while: closing
    /// a socket with unread bytes resets the connection, and the client would lose the answer. If the client received
    /// its answer too slowly, the connection is reset; otherwise the system would keep the unsent part of the answer in
    /// memory.
    void close_gently();

    /// Arranges that closing resets the connection, so that the client does not mistake a partial answer for a whole
    /// one.
    void reset() { resets_ = true; }

    /// Moves the connection's slot to the class that the current request needs; returns false if that class is full.
    bool move_to(ConnectionClass connection_class) { return slot_ == nullptr || slot_->move_to(connection_class); }

    /// Whether the connection is in the reserve. Such connections are closed after their first request.
    bool in_reserve() const { return slot_ != nullptr && slot_->connection_class() == ConnectionClass::Reserve; }

    /// The client or proxy that connected.
    const Peer& peer() const { return peer_; }

    /// The sender of the current request: the peer or, if the peer is a trusted proxy, the client that the proxy names.
    const Peer& client() const { return client_; }
    void set_client(Peer client) { client_ = std::move(client); }

    /// Name of the sender for fair queueing: its address, unless name_client() has set a name.
    const std::string& client_name() const { return client_name_.empty() ? client_.address : client_name_; }
    void name_client(std::string name, std::string key) {
        client_name_ = std::move(name);
        key_ = std::move(key);
    }

    /// Name of the API key of the current request; empty: none.
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

    /// The progress of a body or an answer, regardless of its framing.
    struct Transfer {
        Clock::time_point begun = Clock::now();
        Clock::time_point moved = begun;  ///< time of the latest progress
        std::uint64_t bytes = 0;

        void move_to(std::uint64_t total);
    };

    /// A body that is being read.
    struct Body {
        Body(Capacity* capacity, bool chunked, std::uint64_t size, std::size_t max_size, std::uint64_t first)
            : limit(max_size), begin(first), left(size), at_end(!chunked), held(capacity) {}

        const std::size_t limit;    ///< maximum size of the body
        const std::uint64_t begin;  ///< position of the body's first byte within the request
        std::uint64_t left;         ///< bytes of the plain body or of the current chunk that are not passed on yet
        bool at_end;                ///< no chunk follows the bytes that `left` counts
        std::string framing;        ///< framing that is passed on before the bytes that `left` counts
        Transfer progress;          ///< counts the bytes that were passed on, without framing
        CountedBytes held;
        HttpResult<void> outcome;

        bool is_complete() const { return framing.empty() && left == 0 && at_end; }
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
    std::uint64_t heads_ = 0;   ///< number of heads that were read or attempted
    bool between_requests_ = true;
    bool too_slow_ = false;  ///< the client received an answer too slowly
    bool resets_ = false;
    std::uint64_t bytes_in_ = 0;
    std::uint64_t bytes_out_ = 0;
};

}  // namespace ccdt::server

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/capacity.h"
#include "server/http/http.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// Times that a client may take for its part. Under pressure it has less: see Capacity.
struct Patience {
    std::chrono::milliseconds header{10'000};  ///< for the whole head of a request
    /// Longest pause within a body or an answer, and what it may take over that at the least rate, 32 KiB/s.
    std::chrono::milliseconds body{30'000};
    std::chrono::milliseconds idle{60'000};  ///< between two requests; a thread rests as long before it ends
};

/// One client's socket, with what was read from it and not yet used.
///
/// Belongs to the thread that serves the client. Requests are read one after another: the head, then, if whoever
/// answers wants it, the body. A body that was not read to its end leaves the connection unusable: its bytes must
/// never be taken for the next request. No wait is longer than the client's deadlines, whatever it sends or takes.
class Connection {
public:
    using Milliseconds = std::chrono::milliseconds;

    /// Does not own the socket. The capacity and the place, if there are any, must outlive the connection.
    explicit Connection(int socket, const Patience& patience = {}, Capacity* capacity = nullptr,
                        Place* place = nullptr);

    /// Waits for the first byte of the next request.
    /// @param give_up  asked about five times a second with the time waited so far
    /// @returns        false if the client closed the connection or the wait was given up
    bool wait_for_request(const std::function<bool(Milliseconds waited)>& give_up);

    /// Reads the header by which a proxy tells who connected to it, if there is one: then that is the peer. To be
    /// called once the first bytes are there. Problems: 400 malformed, 408 too slow. The connection is then unusable.
    HttpResult<void> read_proxy_header();

    /// Problems: 400 malformed, 408 too slow, 431 too large. The connection is then unusable.
    HttpResult<Request> read_head();

    /// Reads the body that `request`, the last head read, announces; at most once for each head.
    ///
    /// Tells a client that waits for it to go ahead. Problems: 400 malformed, 408 too slow, 411 not announced, 413 more
    /// bytes than the limit, at once if the head says so, 503 the clients' bodies take too much memory.
    HttpResult<std::string> read_body(const Request& request, std::size_t limit);

    /// Whether the current request is the connection's first: whoever connected had it to ask.
    bool is_on_first_request() const { return heads_ <= 1; }

    /// Whether all of the last request was read: the next byte begins another.
    bool between_requests() const { return between_requests_; }

    /// Whether the client closed its side. Half-closed counts: browsers and proxies close both.
    bool client_gone() const;

    /// Sends bytes; false if the client takes nothing any more, or too slowly.
    bool write(std::string_view bytes);

    /// Closes our side. If bytes of the client were left unread, the rest of them is thrown away for a while: closing
    /// with unread bytes resets the connection, and the client would lose the answer. A client that took its answer
    /// too slowly is reset, or the system would keep the rest for it.
    void close_gently();

    /// Has the connection reset when it is closed, so that the client takes what came for no whole answer.
    void reset() { resets_ = true; }

    /// Moves the connection's place to where the current request needs it; false if that room is full.
    bool move_to(Room room) { return place_ == nullptr || place_->move_to(room); }

    /// Whether it is one of those that are closed after their first request.
    bool in_reserve() const { return place_ != nullptr && place_->room() == Room::Reserve; }

    /// Who connected.
    const Peer& peer() const { return peer_; }

    /// Who sent the current request: the peer, unless a proxy is it and asks for another.
    const Peer& client() const { return client_; }
    void set_client(Peer client) { client_ = std::move(client); }

    /// Name of who sent the current request, for taking turns: its address unless it is known better.
    const std::string& client_name() const { return client_name_.empty() ? client_.address : client_name_; }
    void name_client(std::string name, std::string key) {
        client_name_ = std::move(name);
        key_ = std::move(key);
    }

    /// The name of the API key that the current request came with; empty: none.
    const std::string& key() const { return key_; }

    std::uint64_t bytes_in() const { return bytes_in_; }  ///< of the current request
    std::uint64_t bytes_out() const { return bytes_out_; }

private:
    using Clock = std::chrono::steady_clock;
    using Deadline = std::function<Clock::time_point()>;
    using Fill = std::function<HttpResult<void>()>;

    /// Bytes that were received, of which those at the front are used first.
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

    /// A body or an answer on its way; how it is framed does not count.
    struct Transfer {
        Clock::time_point begun;
        Clock::time_point moved;  ///< when last
        std::uint64_t bytes = 0;

        void move_to(std::uint64_t total);
    };

    bool is_pressed() const { return capacity_ != nullptr && (capacity_->is_pressed() || capacity_->is_closing()); }
    bool wait_for_bytes(const std::function<bool(Milliseconds waited)>& give_up) const;
    Clock::time_point deadline(const Transfer& transfer) const;
    bool wait(short events, const Deadline& deadline) const;
    HttpResult<void> fill(const Deadline& deadline);
    Fill fill_head();
    HttpResult<void> fill(const std::string& body, HeldBytes& held);
    HttpResult<std::size_t> find_line_end(std::size_t begin, std::size_t limit, const Fill& fill_up);
    HttpResult<std::string_view> read_line(const Fill& fill_up);
    HttpResult<void> append(std::string& body, std::uint64_t size, const Fill& fill_up);
    HttpResult<std::string> read_plain(std::uint64_t size);
    HttpResult<std::string> read_chunked(std::size_t limit);
    HttpResult<void> skip_chunk_end(const Fill& fill_up);
    HttpResult<void> skip_trailers(const Fill& fill_up);
    std::string_view use(std::size_t size);

    const int socket_;
    const Patience patience_;
    Capacity* const capacity_;
    Place* const place_;
    Peer peer_;
    Peer client_;
    std::string client_name_;
    std::string key_;
    Unread unread_;
    Transfer body_;  ///< that of the current request
    std::uint64_t heads_ = 0;  ///< that were asked for
    bool between_requests_ = true;
    bool too_slow_ = false;  ///< the client, for its answer
    bool resets_ = false;
    std::uint64_t bytes_in_ = 0;
    std::uint64_t bytes_out_ = 0;
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http_server.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "server/http/connection_threads.h"
#include "server/http/http_library.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;

/// Time-out of idle connections in three cases: Capacity::is_pressed(); the connection has a reserve or stream slot;
/// the server drains and processes no request.
constexpr milliseconds kIdleUnderPressure{500};

/// Time for which the connection of a refused client stays open, so that the client can read the answer.
constexpr milliseconds kTimeToRead{500};

/// Pause after accept() failed for lack of descriptors or memory.
constexpr milliseconds kRecovery{10};

/// Maximum time that a new connection waits for a thread. Meanwhile, idle connections are closed, which frees their
/// threads.
constexpr milliseconds kTimeToFreeThread{500};

/// Time to complete the TCP handshakes that are in progress when the socket begins to refuse new connections. Short,
/// because load balancers are nearby.
constexpr milliseconds kHandshake{2};

/// Interval at which the server looks for completed handshakes during that time.
constexpr milliseconds kHandshakeStep{1};

using Clock = std::chrono::steady_clock;

/// Increments a counter during the lifetime of this object.
class Counted {
public:
    explicit Counted(std::atomic<int>& count) : count_(count) { ++count_; }
    ~Counted() { --count_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

private:
    std::atomic<int>& count_;
};

/// Runs a task and ignores exceptions, so that a failure, most likely a lack of memory, affects only one client.
template <class Task>
void contain(const Task& task) {
    try {
        task();
    } catch (...) {
        // The error cannot be reported: the connection is already broken, and the log itself may have failed.
    }
}

tl::unexpected<Problem> refusal(ConnectionSlot::Entry entry) {
    const std::string reason = entry == ConnectionSlot::Entry::AddressFull
                                   ? "this address has too many connections (max-connections-per-address)"
                                   : "too many connections are open (max-connections)";
    return busy(503, reason, std::chrono::seconds(1));
}

bool is_fatal(int accept_error) {
    return accept_error == EBADF || accept_error == EINVAL || accept_error == ENOTSOCK || accept_error == EOPNOTSUPP;
}

}  // namespace

/// Keeps the sockets of refused clients open for kTimeToRead. Nothing is read from them. Closing a socket with unread
/// bytes at once would reset the connection, and the client might lose the answer.
class RefusedClients {
public:
    /// @param max_sockets  maximum number of sockets kept open; beyond it, the oldest is closed
    explicit RefusedClients(std::size_t max_sockets) : max_sockets_(max_sockets) {}

    bool empty() const { return sockets_.empty(); }

    void add(UniqueFd socket) {
        sockets_.push_back({std::move(socket), Clock::now()});
        if (sockets_.size() > max_sockets_) sockets_.pop_front();
    }

    void close_old() {
        while (!sockets_.empty() && Clock::now() >= sockets_.front().since + kTimeToRead) sockets_.pop_front();
    }

private:
    struct Entry {
        UniqueFd socket;
        Clock::time_point since;
    };

    const std::size_t max_sockets_;
    std::deque<Entry> sockets_;
};

HttpServer::HttpServer(ListeningSocket listener, const Patience& patience, const Capacity::Limits& limits,
                       TrustedProxies proxies, Handler handler, Logger logger, Warn warn)
    : listener_(std::move(listener)),
      patience_(patience),
      capacity_(limits),
      proxies_(std::move(proxies)),
      handler_(std::move(handler)),
      logger_(std::move(logger)),
      warn_(std::move(warn)) {}

bool HttpServer::serve() {
    ConnectionThreads threads(patience_.idle);
    RefusedClients refused(capacity_.limits().refused);
    while (!draining_) {
        listener_.wait(refused.empty() ? std::nullopt : std::optional(kTimeToRead));
        refused.close_old();
        if (accept_next(threads, refused) == Next::Failed) return false;
    }
    accept_last(threads, refused);
    listener_.shut_down();
    return true;
}

void HttpServer::drain() {
    draining_ = true;
    capacity_.close();
    listener_.refuse_newcomers();
}

HttpServer::Next HttpServer::accept_next(ConnectionThreads& threads, RefusedClients& refused) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    UniqueFd socket(accept4(listener_.descriptor(), reinterpret_cast<sockaddr*>(&address), &size, SOCK_CLOEXEC));
    if (socket) {
        contain([&] { receive(std::move(socket), describe_peer(address), threads, refused); });
        return Next::Accepted;
    }
    if (is_fatal(errno)) return Next::Failed;
    if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) contain([&, error = errno] { recover(error); });
    return Next::Nobody;
}

/// Closes an idle connection and pauses, after accept() failed for lack of descriptors or memory.
void HttpServer::recover(int accept_error) {
    capacity_.close_first_idle();
    std::this_thread::sleep_for(kRecovery);
    if (std::exchange(warned_, true)) return;
    warn_(std::string("a connection could not be accepted: ") + std::strerror(accept_error) +
          "; idle connections are closed to make room. Further failures of this kind are not logged");
}

/// Accepts the connections that existed, or whose handshake had begun, when the socket began to refuse new connections.
void HttpServer::accept_last(ConnectionThreads& threads, RefusedClients& refused) {
    const auto end = Clock::now() + kHandshake;
    for (int remaining = ListeningSocket::kBacklog; remaining > 0; --remaining) {
        if (accept_next(threads, refused) == Next::Accepted) continue;
        if (Clock::now() >= end) return;
        std::this_thread::sleep_for(kHandshakeStep);
    }
}

/// Starts a thread for a connection; the thread then owns the socket. If the system has no more threads, closes idle
/// connections, which frees their threads.
bool HttpServer::start(ConnectionThreads& threads, int socket, const std::shared_ptr<ConnectionSlot>& slot) {
    const auto end = Clock::now() + kTimeToFreeThread;
    while (true) {
        slot->begin_idle(socket);
        if (threads.run([this, socket, slot] { serve_socket(UniqueFd(socket), *slot); })) return true;
        slot->end_idle();
        if (Clock::now() >= end || !capacity_.close_first_idle()) return false;
        std::this_thread::sleep_for(kRecovery);
    }
}

/// Starts a thread for a new connection, or answers that the server is full.
void HttpServer::receive(UniqueFd socket, const Peer& peer, ConnectionThreads& threads, RefusedClients& refused) {
    const int yes = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
    const auto slot = std::make_shared<ConnectionSlot>(capacity_, counted_address(peer));
    auto entry = slot->entry();
    if (entry == ConnectionSlot::Entry::Admitted) {
        if (start(threads, socket.get(), slot)) {
            socket.release();
            return;
        }
        entry = ConnectionSlot::Entry::Full;
    }
    contain([&] {
        Connection connection(socket.get(), patience_, &capacity_);
        answer(connection, {}, refusal(entry), true);
    });
    ::shutdown(socket.get(), SHUT_WR);
    refused.add(std::move(socket));
}

void HttpServer::serve_socket(const UniqueFd& socket, ConnectionSlot& slot) {
    contain([&] {
        Connection connection(socket.get(), patience_, &capacity_, &slot);
        contain([&] { serve_connection(connection, slot); });
        connection.close_gently();
    });
    slot.end_idle();  // must precede the closing of the socket
}

void HttpServer::serve_connection(Connection& connection, ConnectionSlot& slot) {
    // A new connection has less time than an idle one to send a request.
    auto longest = patience_.header;
    const auto should_stop = [&](milliseconds waited) {
        const bool idles_elsewhere = slot.connection_class() != ConnectionClass::Common;
        const bool pressed = capacity_.is_pressed() || idles_elsewhere || (draining_ && busy_ == 0);
        return waited >= (pressed ? std::min(longest, kIdleUnderPressure) : longest);
    };
    if (proxies_.include(connection.peer()) && connection.wait_for_request(should_stop)) {
        const auto told = connection.read_proxy_header().and_then([&] { return count(connection.peer(), slot); });
        if (!told) {
            answer(connection, {}, told, true);
            return;
        }
    }
    for (std::size_t remaining = kRequestsPerConnection; remaining > 0 && connection.wait_for_request(should_stop);
         --remaining) {
        const Counted busy(busy_);
        auto request = connection.read_head();
        const auto received =
            request.and_then(check_request).and_then([&] { return take_client(*request, connection, slot); });
        const bool last = !received || remaining == 1;
        if (!answer(connection, std::move(request).value_or(Request()), received, last)) break;
        slot.count_by(counted_address(connection.peer()));
        longest = patience_.idle;
    }
}

/// Identifies the client, and counts the connection towards the limit of the client's address until the answer is sent.
HttpResult<void> HttpServer::take_client(const Request& request, Connection& connection, ConnectionSlot& slot) const {
    connection.set_client(client_of(request, connection.peer(), proxies_));
    return count(connection.client(), slot);
}

HttpResult<void> HttpServer::count(const Peer& client, ConnectionSlot& slot) const {
    if (!slot.count_by(counted_address(client))) return refusal(ConnectionSlot::Entry::AddressFull);
    return {};
}

/// Returns the address whose limit a connection counts towards; empty for trusted proxies. These have no limit, so that
/// many clients of a load balancer cannot make its health checks fail.
std::string HttpServer::counted_address(const Peer& client) const {
    return proxies_.include(client) ? "" : client.address;
}

/// Processes a request with cpp-httplib, and logs it.
/// @param last  whether this is known to be the last request of the connection
/// @returns     whether another request may follow
bool HttpServer::answer(Connection& connection, Request request, const HttpResult<void>& received, bool last) {
    const auto start = Clock::now();
    Response response;
    const bool written = process_request(connection, request, response, last, [&](const HttpResult<void>& dispatched) {
        response = handler_(request, received ? dispatched : received, connection);
        last = last || draining_ || response.status == kClientGone || !request.keep_alive || connection.in_reserve() ||
               !connection.between_requests() || (response.stream && !response.length && request.is_http_1_0);
    });
    const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start;
    logger_({std::move(request), std::move(response), connection.client().name, connection.bytes_in(),
             connection.bytes_out(), elapsed.count()});
    return written && !last;
}

}  // namespace ccdt::server

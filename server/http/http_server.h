#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "server/http/capacity.h"
#include "server/http/connection.h"
#include "server/http/http.h"
#include "server/http/proxies.h"
#include "server/http/sockets.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

class AnswerWriter;
class ConnectionThreads;
class RefusedClients;

/// A request and what became of it, for the log.
struct Exchange {
    Request request;
    Response response;
    std::string client;
    std::uint64_t bytes_in = 0;
    std::uint64_t bytes_out = 0;
    double milliseconds = 0;
};

/// The connection layer: accepts clients, reads their requests and writes the answers.
///
/// Every connection has a thread of its own from the start, and there are as many as connections may be open; one that
/// is not needed is kept for as long as a connection without a request. So none waits for a thread: clients that send
/// nothing, or send or read slowly, keep nobody from being answered, only a place each (some 40 kB), of which an
/// address has its share, and which they lose sooner the fewer are left. An event loop would hold more of them, but a
/// body or an answer that is not waited for needs its own state machine, and handlers that cannot simply read and
/// write. Connections beyond the limits are told so by the thread that accepts.
class HttpServer {
public:
    /// Answers a request. If it was not received whole and well formed it is as far as it could be read, and the answer
    /// says why. Called on many threads at once; must not throw.
    using Handler = std::function<Response(const Request&, const HttpResult<void>& received, Connection&)>;
    using Logger = std::function<void(const Exchange&)>;
    using Warn = std::function<void(const std::string&)>;

    /// @param listener  where clients wait until `serve` is called
    /// @param proxies   their clients count, not they
    /// @param warn      tells whoever runs the server, once, that connections cannot be accepted
    HttpServer(
        ListeningSocket listener, const Patience& patience, const Capacity::Limits& limits, TrustedProxies proxies,
        Handler handler, Logger logger, Warn warn = [](const std::string&) {});

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Serves until `drain`; returns once everybody who had connected by then has left, with an answer to each request.
    /// @returns  false if accepting failed for any other reason
    bool serve();

    /// Makes `serve` end: nobody connects any more. From any thread, at any time.
    void drain();

    /// Connections, open and refused.
    Capacity::Counts connections() const { return capacity_.counts(); }

private:
    enum class Next { Accepted, Nobody, Failed };

    Next accept_next(ConnectionThreads& threads, RefusedClients& refused);
    void recover(int accept_error);
    void accept_last(ConnectionThreads& threads, RefusedClients& refused);
    bool start(ConnectionThreads& threads, int socket, const std::shared_ptr<Place>& place);
    void receive(UniqueFd socket, const Peer& peer, ConnectionThreads& threads, RefusedClients& refused);
    void serve_socket(const UniqueFd& socket, Place& place);
    void serve_connection(Connection& connection, Place& place);
    HttpResult<void> take_client(const Request& request, Connection& connection, Place& place) const;
    HttpResult<void> count(const Peer& client, Place& place) const;
    std::string counted_address(const Peer& client) const;
    bool answer(Connection& connection, AnswerWriter& writer, Request request, const HttpResult<void>& received,
                bool last);
    std::optional<Response> handle(const Request& request, const HttpResult<void>& received,
                                   Connection& connection) const;

    const ListeningSocket listener_;
    const Patience patience_;
    Capacity capacity_;
    const TrustedProxies proxies_;
    const Handler handler_;
    const Logger logger_;
    const Warn warn_;
    bool warned_ = false;
    std::atomic<bool> draining_ = false;
    std::atomic<int> busy_ = 0;  ///< connections with a request
};

}  // namespace ccdt::server

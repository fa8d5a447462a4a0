// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/result.h"
#include "server/http/capacity.h"
#include "server/http/connection.h"
#include "server/http/http.h"
#include "server/http/proxies.h"
#include "server/http/sockets.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

class ConnectionThreads;
class RefusedClients;

/// A request and its response, for the log.
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
/// Every connection has its own thread from the start, and there may be as many threads as open connections. An idle
/// thread is kept for the same time as an idle connection. So no connection waits for a thread: clients that send
/// nothing, or send or receive slowly, delay nobody. Each of them only takes a slot (some 40 kB). The number of slots
/// per address is limited, and time-outs shrink as slots become scarce. The accepting thread refuses connections beyond
/// the limits.
///
/// An event loop would hold more connections. But it would need a state machine for every body and answer, and handlers
/// could not simply read and write.
class HttpServer {
public:
    /// Answers a request. If the request was incomplete or malformed, `received` says why, and the request contains
    /// what could be parsed. Called on many threads at once. If it throws, the client gets a 500 without a body.
    using Handler = std::function<Response(const Request&, const HttpResult<void>& received, Connection&)>;
    using Logger = std::function<void(const Exchange&)>;
    using Warn = std::function<void(const std::string&)>;

    /// @param listener  socket on which clients wait until `serve` is called
    /// @param proxies   trusted proxies; a connection through such a proxy is counted by the address of its client
    /// @param warn      reports to the operator, once, that connections cannot be accepted
    HttpServer(
        ListeningSocket listener, const Patience& patience, const Capacity::Limits& limits, TrustedProxies proxies,
        Handler handler, Logger logger, Warn warn = [](const std::string&) {});

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Serves until `drain` is called. Then answers the requests of all connections that were made before, and returns
    /// once these connections are closed.
    /// @returns  false if it ended because accepting connections failed
    bool serve();

    /// Makes `serve` end: new connections are refused. May be called from any thread, at any time.
    void drain();

    /// Numbers of open and refused connections.
    Capacity::Counts connections() const { return capacity_.counts(); }

private:
    enum class Next { Accepted, Nobody, Failed };

    Next accept_next(ConnectionThreads& threads, RefusedClients& refused);
    void recover(int accept_error);
    void accept_last(ConnectionThreads& threads, RefusedClients& refused);
    bool start(ConnectionThreads& threads, int socket, const std::shared_ptr<ConnectionSlot>& slot);
    void receive(UniqueFd socket, const Peer& peer, ConnectionThreads& threads, RefusedClients& refused);
    void serve_socket(const UniqueFd& socket, ConnectionSlot& slot);
    void serve_connection(Connection& connection, ConnectionSlot& slot);
    HttpResult<void> take_client(const Request& request, Connection& connection, ConnectionSlot& slot) const;
    HttpResult<void> count(const Peer& client, ConnectionSlot& slot) const;
    std::string counted_address(const Peer& client) const;
    bool answer(Connection& connection, Request request, const HttpResult<void>& received, bool last);

    const ListeningSocket listener_;
    const Patience patience_;
    Capacity capacity_;
    const TrustedProxies proxies_;
    const Handler handler_;
    const Logger logger_;
    const Warn warn_;
    bool warned_ = false;
    std::atomic<bool> draining_ = false;
    std::atomic<int> busy_ = 0;  ///< number of connections with a request
};

}  // namespace ccdt::server

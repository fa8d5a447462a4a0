// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
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
/// Every connection has its own thread, so slow or silent clients delay nobody. Such a client only occupies a slot,
/// which takes about 40 kB of memory. The number of slots per address is limited, and time-outs shrink as slots become
/// scarce. Idle threads have the same time-out as idle connections. The accepting thread refuses connections beyond the
/// limits.
///
/// An event loop could hold more connections, but would need a state machine for every body and answer. Handlers could
/// then not read and write with blocking calls.
class HttpServer {
public:
    /// Answers a request. If the request is refused, `received` contains the problem. The request is empty if its head
    /// could not be read. Called on many threads at once. If the handler throws, the client gets a 500 without a body.
    using Handler = std::function<Response(const Request&, const HttpResult<void>& received, Connection&)>;
    using Logger = std::function<void(const Exchange&)>;
    using Warn = std::function<void(const std::string&)>;

    /// @param listener  socket on which clients wait until `serve` is called
    /// @param proxies   trusted proxies; their connections count towards the limits of the clients that they name
    /// @param warn      reports to the operator, once, that connections cannot be accepted
    HttpServer(
        ListeningSocket listener, const Patience& patience, const Capacity::Limits& limits, TrustedProxies proxies,
        Handler handler, Logger logger, Warn warn = [](const std::string&) {});

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Serves until `drain` is called. Then answers requests on existing connections until all are closed.
    /// @returns  false if accepting connections failed permanently
    bool serve();

    /// Refuses new connections and makes `serve` end. May be called from any thread, at any time.
    void drain();

    /// Returns the numbers of open and refused connections.
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
    std::atomic<int> busy_ = 0;  ///< number of connections that are processing a request
};

}  // namespace ccdt::server

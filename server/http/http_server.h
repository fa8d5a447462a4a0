#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "server/http/capacity.h"
#include "server/http/connection.h"
#include "server/http/http.h"

namespace ccdt::server {

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
    /// Answers a request, or says why not: with a fault the request is as far as it could be read.
    /// Called on many threads at once; must not throw.
    using Handler = std::function<Response(const Request&, const std::optional<Fault>&, Connection&)>;
    using Logger = std::function<void(const Exchange&)>;

    HttpServer(const Patience& patience, const Capacity::Limits& limits, Handler handler, Logger logger);
    ~HttpServer();

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// @param address  one of this machine, or `unix:` and a path
    /// @param port     0: any that is free
    /// @returns        the port, 0 for a path
    /// Errors (Unusable): the address is unknown; another server listens there.
    Result<int> bind(const std::string& address, int port);

    /// Serves until `drain`; returns once every request that was accepted is answered.
    /// @returns  false if accepting failed for any other reason
    bool serve();

    /// Makes `serve` accept no more. From any thread, at any time after `bind`.
    void drain();

    /// Connections, open and refused.
    Capacity::Counts connections() const;

private:
    class Reception;
    std::unique_ptr<Reception> reception_;
};

}  // namespace ccdt::server

#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "server/connection.h"
#include "server/http.h"

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

/// The connection layer: accepts clients, reads their requests and writes the answers, one thread a connection.
class HttpServer {
public:
    /// Answers a request, or says why not: with a fault the request is as far as it could be read.
    /// Called on many threads at once; must not throw.
    using Handler = std::function<Response(const Request&, const std::optional<Fault>&, Connection&)>;
    using Logger = std::function<void(const Exchange&)>;

    /// @param threads  connections served at the same time; more of them wait
    HttpServer(std::size_t threads, Handler handler, Logger logger);
    ~HttpServer();

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// @param port  0: any that is free
    /// @returns     the port
    /// Errors (Unusable): the address is unknown, the port taken.
    Result<int> bind(const std::string& address, int port);

    /// Serves until `drain`; returns once every request that was accepted is answered.
    /// @returns  false if accepting failed for any other reason
    bool serve();

    /// Makes `serve` accept no more. From any thread, at any time after `bind`.
    void drain();

private:
    class Listener;
    std::unique_ptr<Listener> listener_;
};

}  // namespace ccdt::server

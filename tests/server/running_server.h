// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <thread>

#include "server/http/http_server.h"

namespace ccdt::server {

/// An HttpServer on a free port. It serves in a separate thread until `stop` or the destructor is called.
class RunningServer {
public:
    RunningServer(const Capacity::Limits& limits, HttpServer::Handler handler, HttpServer::Logger logger);
    ~RunningServer() { stop(); }

    RunningServer(const RunningServer&) = delete;
    RunningServer& operator=(const RunningServer&) = delete;

    void stop();

    int port() const { return port_; }
    Capacity::Counts connections() const { return server_.connections(); }

private:
    RunningServer(ListeningSocket listener, const Capacity::Limits& limits, HttpServer::Handler handler,
                  HttpServer::Logger logger);

    const int port_;
    HttpServer server_;
    std::jthread thread_;
};

/// A connection to a port of this machine.
class Client {
public:
    explicit Client(int port);
    ~Client();

    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    /// Sends a request.
    /// @returns  false if the server has closed the connection
    bool say(std::string_view request) const;

    /// Sends a request, and receives until the connection ends or the server sends nothing for test::kPatience.
    /// @returns  the received bytes
    std::string ask(std::string_view request) const;

private:
    int socket_ = -1;
};

}  // namespace ccdt::server

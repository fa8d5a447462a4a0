// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/running_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "tests/server/waiting.h"

namespace ccdt::server {

RunningServer::RunningServer(const Capacity::Limits& limits, HttpServer::Handler handler, HttpServer::Logger logger)
    : RunningServer(ListeningSocket::open("127.0.0.1", 0).value(), limits, std::move(handler), std::move(logger)) {}

RunningServer::RunningServer(ListeningSocket listener, const Capacity::Limits& limits, HttpServer::Handler handler,
                             HttpServer::Logger logger)
    : port_(listener.port()),
      server_(std::move(listener), {}, limits, {}, std::move(handler), std::move(logger)),
      thread_([this] { EXPECT_TRUE(server_.serve()); }) {}

void RunningServer::stop() {
    if (!thread_.joinable()) return;
    server_.drain();
    thread_.join();
}

Client::Client(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const timeval patience{test::kPatience.count(), 0};
    EXPECT_EQ(setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience)), 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
}

Client::~Client() {
    ::close(socket_);
}

bool Client::say(std::string_view request) const {
    return send(socket_, request.data(), request.size(), MSG_NOSIGNAL) >= 0;
}

std::string Client::ask(std::string_view request) const {
    std::string answer;
    if (!say(request)) return answer;
    std::array<char, 4096> buffer{};
    while (true) {
        const ssize_t size = recv(socket_, buffer.data(), buffer.size(), 0);
        if (size <= 0) return answer;
        answer.append(buffer.data(), static_cast<std::size_t>(size));
    }
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/health.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <string_view>

#include <sys/socket.h>

#include "server/http/sockets.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kRequest = "GET /health/live HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
constexpr std::string_view kHealthy = "HTTP/1.1 200 ";

}  // namespace

Result<void> check_health(const Config& config) {
    const auto unhealthy = [](const std::string& why) { return failure(ErrorCode::Unusable, "unhealthy: " + why); };
    const auto socket = connect_to(config.bind, config.port, std::chrono::seconds(3));
    if (!socket) return tl::unexpected(socket.error());
    if (send(socket->get(), kRequest.data(), kRequest.size(), MSG_NOSIGNAL) < 0) return unhealthy(std::strerror(errno));
    std::string answer(kHealthy.size(), '\0');
    const ssize_t received = recv(socket->get(), answer.data(), answer.size(), MSG_WAITALL);
    if (received < 0) return unhealthy(std::strerror(errno));
    if (answer != kHealthy) return unhealthy("the answer begins with '" + answer.substr(0, answer.find('\r')) + "'");
    return {};
}

}  // namespace ccdt::server

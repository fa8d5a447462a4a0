// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/service_manager.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include <sys/socket.h>
#include <sys/un.h>

#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

/// Sends a datagram to a Unix socket.
/// @param name  path of the socket, or `@` and its abstract name
/// @returns     0, or the errno of the failure
int send_to(std::string_view name, std::string_view message) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (name.size() >= sizeof(address.sun_path)) return ENAMETOOLONG;
    std::ranges::copy(name, address.sun_path);
    if (name.starts_with('@')) address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    const UniqueFd sender(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!sender) return errno;
    const ssize_t sent = sendto(sender.get(), message.data(), message.size(), MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&address), size);
    return sent < 0 ? errno : 0;
}

}  // namespace

Result<void> notify_service_manager(std::string_view state) {
    const char* const name = std::getenv("NOTIFY_SOCKET");
    if (name == nullptr || *name == '\0') return {};
    const int error = send_to(name, state);
    if (error == 0) return {};
    return failure(ErrorCode::Internal,
                   std::string("NOTIFY_SOCKET: cannot send to '") + name + "': " + std::strerror(error));
}

}  // namespace ccdt::server

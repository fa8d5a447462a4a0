// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/sockets.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace ccdt::server {
namespace {

constexpr int kKind = SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK;
constexpr std::string_view kPathPrefix = "unix:";

tl::unexpected<Error> cannot_listen(const std::string& where, const std::string& why) {
    return failure(ErrorCode::Unusable, "cannot listen on " + where + ": " + why);
}

std::string name_of(const std::string& host, int port) {
    return host + " port " + std::to_string(port);
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Result<Addresses> look_up(const std::string& host, int port) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
        return failure(ErrorCode::Unusable, name_of(host, port) + ": the address is unknown");
    return Addresses(found, freeaddrinfo);
}

Result<sockaddr_un> address_of_path(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof(address.sun_path))
        return failure(ErrorCode::Unusable,
                       path + ": a path must have 1 to " + std::to_string(sizeof(address.sun_path) - 1) + " bytes");
    path.copy(address.sun_path, path.size());
    return address;
}

Result<UniqueFd> connect_to(int family, const sockaddr* address, socklen_t size, std::chrono::milliseconds patience) {
    UniqueFd descriptor(socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(patience);
    const timeval longest{seconds.count(), std::chrono::microseconds(patience - seconds).count()};
    for (const int option : {SO_RCVTIMEO, SO_SNDTIMEO})
        setsockopt(descriptor.get(), SOL_SOCKET, option, &longest, sizeof(longest));
    if (connect(descriptor.get(), address, size) == 0) return descriptor;
    return failure(ErrorCode::Unusable, std::string("cannot connect: ") + std::strerror(errno));
}

const sockaddr* generic(const void* address) {
    return static_cast<const sockaddr*>(address);
}

/// Returns a listening socket; none after a failure, with the reason in errno.
UniqueFd listen_on(int family, const sockaddr* address, socklen_t size) {
    UniqueFd descriptor(socket(family, kKind, 0));
    if (!descriptor) return {};
    const int yes = 1;
    // SO_REUSEPORT is not set: with it, a second instance could start and would get half of the clients.
    if (family != AF_UNIX) setsockopt(descriptor.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    if (bind(descriptor.get(), address, size) == 0 && listen(descriptor.get(), ListeningSocket::kBacklog) == 0)
        return descriptor;
    const int reason = errno;
    descriptor.reset();
    errno = reason;
    return {};
}

bool has_listener(const sockaddr_un& address) {
    const int descriptor = socket(AF_UNIX, kKind, 0);
    const bool connected = connect(descriptor, generic(&address), sizeof(address)) == 0;
    // EAGAIN means that the backlog is full, so somebody listens.
    const bool listens = connected || errno == EAGAIN;
    close(descriptor);
    return listens;
}

/// Removes a socket that a crashed server left behind.
void remove_stale(const sockaddr_un& address) {
    struct stat found {};
    const bool is_socket = lstat(address.sun_path, &found) == 0 && S_ISSOCK(found.st_mode);
    if (is_socket && !has_listener(address)) unlink(address.sun_path);
}

}  // namespace

Peer describe_peer(const sockaddr_storage& address) {
    if (address.ss_family == AF_INET) {
        sockaddr_in of{};
        std::memcpy(&of, &address, sizeof(of));
        return describe_peer(IpAddress(of.sin_addr), ntohs(of.sin_port));
    }
    if (address.ss_family == AF_INET6) {
        sockaddr_in6 of{};
        std::memcpy(&of, &address, sizeof(of));
        return describe_peer(IpAddress(of.sin6_addr), ntohs(of.sin6_port));
    }
    if (address.ss_family != AF_UNIX) return {};
    return {.name = "unix", .is_local = true};
}

Peer describe_peer(const IpAddress& address, std::optional<std::uint16_t> port) {
    const std::string host = address.text();
    const std::string shown = address.is_version_4() || !port ? host : '[' + host + ']';
    return {
        .name = port ? shown + ':' + std::to_string(*port) : shown, .address = address.of_one_client(), .ip = address};
}

Peer peer_of(int socket) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
    return describe_peer(address);
}

Result<ListeningSocket> ListeningSocket::open(const std::string& bind, int port) {
    UniqueFd refusing(eventfd(0, EFD_CLOEXEC));
    if (!refusing) return cannot_listen(bind, std::strerror(errno));
    auto opened = bind.starts_with(kPathPrefix) ? open_path(bind.substr(kPathPrefix.size())) : open_port(bind, port);
    if (opened) opened->refusing_ = std::move(refusing);
    return opened;
}

Result<ListeningSocket> ListeningSocket::open_path(const std::string& path) {
    const auto address = address_of_path(path);
    if (!address) return tl::unexpected(address.error());
    remove_stale(*address);
    UniqueFd descriptor = listen_on(AF_UNIX, generic(&*address), sizeof(*address));
    if (!descriptor) return cannot_listen(path, std::strerror(errno));
    ListeningSocket opened(std::move(descriptor));
    struct stat ours {};
    if (lstat(path.c_str(), &ours) == 0) {
        opened.path_ = path;
        opened.device_ = ours.st_dev;
        opened.inode_ = ours.st_ino;
    }
    return opened;
}

Result<ListeningSocket> ListeningSocket::open_port(const std::string& host, int port) {
    const auto addresses = look_up(host, port);
    if (!addresses) return tl::unexpected(addresses.error());
    UniqueFd descriptor;
    for (const addrinfo* each = addresses->get(); each != nullptr && !descriptor; each = each->ai_next)
        descriptor = listen_on(each->ai_family, each->ai_addr, each->ai_addrlen);
    if (!descriptor) return cannot_listen(name_of(host, port), std::strerror(errno));
    ListeningSocket opened(std::move(descriptor));

    sockaddr_storage bound{};
    socklen_t size = sizeof(bound);
    getsockname(opened.descriptor(), reinterpret_cast<sockaddr*>(&bound), &size);
    // The port has the same offset in the addresses of both families.
    sockaddr_in of{};
    std::memcpy(&of, &bound, sizeof(of));
    opened.port_ = ntohs(of.sin_port);
    return opened;
}

ListeningSocket::ListeningSocket(ListeningSocket&& other) noexcept
    : descriptor_(std::move(other.descriptor_)),
      refusing_(std::move(other.refusing_)),
      port_(other.port_),
      path_(std::exchange(other.path_, {})),
      device_(other.device_),
      inode_(other.inode_) {}

ListeningSocket::~ListeningSocket() {
    // A server started later may have replaced the socket file.
    struct stat now {};
    if (!path_.empty() && lstat(path_.c_str(), &now) == 0 && now.st_dev == device_ && now.st_ino == inode_)
        unlink(path_.c_str());
}

void ListeningSocket::wait(std::optional<std::chrono::milliseconds> longest) const {
    std::array<pollfd, 2> entries{{{descriptor_.get(), POLLIN, 0}, {refusing_.get(), POLLIN, 0}}};
    poll(entries.data(), entries.size(), longest ? static_cast<int>(longest->count()) : -1);
}

void ListeningSocket::refuse_newcomers() const {
    // The filter's data begin with the TCP header. It drops packets with SYN, which are attempts to connect.
    constexpr std::uint32_t kFlags = 13;
    constexpr std::uint32_t kWhole = 0xffff'ffff;
    std::array<sock_filter, 4> program{{BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kFlags),
                                        BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, TH_SYN, 0, 1),
                                        BPF_STMT(BPF_RET | BPF_K, 0), BPF_STMT(BPF_RET | BPF_K, kWhole)}};
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    setsockopt(descriptor_.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter));
    eventfd_write(refusing_.get(), 1);
}

void ListeningSocket::shut_down() const {
    shutdown(descriptor_.get(), SHUT_RDWR);
}

Result<UniqueFd> connect_to(const std::string& bind, int port, std::chrono::milliseconds patience) {
    if (bind.starts_with(kPathPrefix)) {
        const auto address = address_of_path(bind.substr(kPathPrefix.size()));
        if (!address) return tl::unexpected(address.error());
        return connect_to(AF_UNIX, generic(&*address), sizeof(*address), patience);
    }
    const auto addresses = look_up(bind, port);
    if (!addresses) return tl::unexpected(addresses.error());
    auto connected = connect_to((*addresses)->ai_family, (*addresses)->ai_addr, (*addresses)->ai_addrlen, patience);
    for (const addrinfo* each = (*addresses)->ai_next; each != nullptr && !connected; each = each->ai_next)
        connected = connect_to(each->ai_family, each->ai_addr, each->ai_addrlen, patience);
    return connected;
}

void allow_open_files(std::size_t count) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= count) return;
    limit.rlim_cur = std::min<rlim_t>(count, limit.rlim_max);
    setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace ccdt::server

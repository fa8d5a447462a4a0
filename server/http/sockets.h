#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/result.h"
#include "server/http/ip_address.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// The other end of a connection, or a client for whom a proxy asks.
struct Peer {
    std::string name = "-";            ///< address and, if it is known, port, for the log
    std::string address = {};          ///< what one client has for itself, by which limits count; empty if it has none
    std::optional<IpAddress> ip = {};  ///< none: it has none, or is not known
    bool is_local = false;             ///< came over a Unix socket
};

/// @param address  as `accept` fills it in
Peer describe_peer(const sockaddr_storage& address);
Peer describe_peer(const IpAddress& address, std::optional<std::uint16_t> port = std::nullopt);

/// Peer of a connected socket.
Peer peer_of(int socket);

/// A socket that listens on an address or, after `unix:`, on a path. Closes it at the end, and removes the path.
class ListeningSocket {
public:
    /// @param port  0: any that is free; not used with a path
    /// Errors (Unusable): the address is unknown, it is taken, the path is something other than a socket nobody uses.
    static Result<ListeningSocket> open(const std::string& bind, int port);

    ListeningSocket(ListeningSocket&& other) noexcept;
    ListeningSocket& operator=(ListeningSocket&&) = delete;
    ~ListeningSocket();

    int descriptor() const { return descriptor_; }  ///< does not block
    int port() const { return port_; }              ///< 0 for a path

private:
    explicit ListeningSocket(int descriptor) : descriptor_(descriptor) {}
    static Result<ListeningSocket> open_path(const std::string& path);
    static Result<ListeningSocket> open_port(const std::string& host, int port);

    int descriptor_ = -1;
    int port_ = 0;
    std::string path_;
    dev_t device_ = 0;  ///< with the inode: whether the path is still ours
    ino_t inode_ = 0;
};

/// Connects to where a ListeningSocket of this machine listens; all addresses mean this machine's own.
/// @param patience  for connecting, and for each time that something is sent or received
/// Errors (Unusable): the address is unknown, or nobody listens there.
Result<UniqueFd> connect_to(const std::string& bind, int port, std::chrono::milliseconds patience);

/// Lets this process open so many files, as far as it may: by default many systems allow 1024.
void allow_open_files(std::size_t count);

}  // namespace ccdt::server

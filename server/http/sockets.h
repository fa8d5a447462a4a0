// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "server/http/ip_address.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// The other end of a connection, or the client that a proxy names.
struct Peer {
    std::string name = "-";            ///< text for the log: the address and, if known, the port
    std::string address = {};          ///< IpAddress::of_one_client(), for limits; empty: none
    std::optional<IpAddress> ip = {};  ///< none: the peer has no IP address, or it is unknown
    bool is_local = false;             ///< connected over a Unix socket
};

/// Describes a peer by its address, as set by `accept`, or by its IP address and port.
Peer describe_peer(const sockaddr_storage& address);
Peer describe_peer(const IpAddress& address, std::optional<std::uint16_t> port = std::nullopt);

/// Returns the peer of a connected socket.
Peer peer_of(int socket);

/// A socket that listens on an address or a path (`unix:/path`). The destructor closes it and removes the path.
class ListeningSocket {
public:
    /// Opens a socket on an address and port, or on a path.
    /// @param port  0: any free port; ignored for a path
    /// Errors (Unusable): the address is unknown or in use; the path is not a socket, or another server listens on it.
    static Result<ListeningSocket> open(const std::string& bind, int port);

    /// Maximum number of connections that wait to be accepted.
    static constexpr int kBacklog = 1024;

    ListeningSocket(ListeningSocket&& other) noexcept;
    ListeningSocket& operator=(ListeningSocket&&) = delete;
    ~ListeningSocket();

    /// Waits until a client may have connected, `refuse_newcomers` was called, or the time limit is reached.
    /// @param longest  none: no time limit
    void wait(std::optional<std::chrono::milliseconds> longest) const;

    /// Refuses new connections. Connections in the backlog can still be accepted. May be called from any thread.
    ///
    /// The socket is not shut down, because that would reset the connections in the backlog. Their requests may have
    /// arrived, and a load balancer could not know that the server has not read them. New TCP clients try again after a
    /// second, and are refused after `shut_down`. New Unix clients wait until `shut_down`.
    void refuse_newcomers() const;

    /// Resets connections that still wait to be accepted. Further attempts to connect fail.
    void shut_down() const;

    int descriptor() const { return descriptor_.get(); }  ///< nonblocking
    int port() const { return port_; }                    ///< 0 for a path

private:
    explicit ListeningSocket(UniqueFd descriptor) : descriptor_(std::move(descriptor)) {}
    static Result<ListeningSocket> open_path(const std::string& path);
    static Result<ListeningSocket> open_port(const std::string& host, int port);

    UniqueFd descriptor_;
    UniqueFd refusing_;  ///< eventfd that `refuse_newcomers` sets
    int port_ = 0;
    std::string path_;
    dev_t device_ = 0;  ///< identifies our own socket file, together with `inode_`
    ino_t inode_ = 0;
};

/// Connects to a ListeningSocket on this machine. A wildcard address means this machine.
/// @param patience  time-out for connecting, and for each later send and receive
/// Errors (Unusable): the address is unknown, or nobody listens there.
Result<UniqueFd> connect_to(const std::string& bind, int port, std::chrono::milliseconds patience);

/// Raises the soft limit of open files to `count`, as far as the hard limit allows. The usual default is 1024.
void allow_open_files(std::size_t count);

}  // namespace ccdt::server

#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

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

    /// Most who wait for being accepted.
    static constexpr int kBacklog = 1024;

    ListeningSocket(ListeningSocket&& other) noexcept;
    ListeningSocket& operator=(ListeningSocket&&) = delete;
    ~ListeningSocket();

    /// Waits until somebody may have connected, `refuse_newcomers` was called, or the time is over.
    /// @param longest  none: however long it takes
    void wait(std::optional<std::chrono::milliseconds> longest) const;

    /// Lets nobody connect any more; who has connected waits on for being accepted. From any thread.
    ///
    /// To shut the socket down instead would reset those who wait, whose requests may be there already: a balancer
    /// could not know that nobody has seen them. TCP alone: elsewhere newcomers wait too, until `shut_down`. Whoever
    /// wants to connect meanwhile asks again after a second, and so soon finds that nobody listens.
    void refuse_newcomers() const;

    /// Resets who still waits, and tells newcomers that nobody listens.
    void shut_down() const;

    int descriptor() const { return descriptor_.get(); }  ///< does not block
    int port() const { return port_; }                    ///< 0 for a path

private:
    explicit ListeningSocket(UniqueFd descriptor) : descriptor_(std::move(descriptor)) {}
    static Result<ListeningSocket> open_path(const std::string& path);
    static Result<ListeningSocket> open_port(const std::string& host, int port);

    UniqueFd descriptor_;
    UniqueFd refusing_;  ///< an event, once newcomers are refused
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

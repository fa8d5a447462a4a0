// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// The children of a process that forks a child for each order of the server. The process must have one thread.
///
/// For each child, this process has a socket to the process that waits for the child. The end of the child is reported
/// through this socket. When the waiting process closes its end, the child is killed.
class ForkedChildren {
public:
    /// Reports the end of a child to the process that waits for it.
    /// @param status  status of waitpid
    /// @param used    processor time of the child
    using ReportEnd = void (*)(const UniqueFd& socket, int status, std::chrono::microseconds used);

    using Files = std::array<UniqueFd, 3>;

    /// @param orders  socket from the server; must preserve message boundaries
    ForkedChildren(UniqueFd orders, ReportEnd report_end);

    /// Whether this object can notice ends of children; false if the system has no more descriptors.
    explicit operator bool() const { return static_cast<bool>(ends_); }

    int orders() const { return orders_.get(); }

    /// Waits for an order. Meanwhile, reports ends of children, kills abandoned children, and replies to probes.
    /// @param order    receives the bytes of the order
    /// @param prepare  prepares for the order; called at most once, when there are no children or nothing has happened
    ///                 for 5 ms
    /// @returns        files of the order, any of which may be empty; none when the server has ended
    std::optional<Files> wait_for_order(std::span<std::byte> order, const std::function<void()>& prepare = {});

    /// Forks the calling process. In the child, no signal is blocked, and the sockets of this object are closed.
    /// @returns  result of the system's fork()
    pid_t fork();

    /// Adds a child made by fork(), with its socket. The end of a child that was not added is not reported.
    void add(pid_t process, UniqueFd socket) { children_.push_back({process, std::move(socket)}); }

private:
    struct Child {
        pid_t process = 0;
        UniqueFd socket;
    };

    static void kill(Child& child);
    void reap();

    UniqueFd orders_;
    UniqueFd ends_;  ///< readable when a child has ended
    const ReportEnd report_end_;
    std::vector<Child> children_;
};

}  // namespace ccdt::server

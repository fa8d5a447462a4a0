// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "server/compute/compute_protocol.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// The main function of a computation process; it does not return.
using ComputeProcess = std::function<void(ComputeFiles files)>;

/// Turns the calling process, which must have one thread, into the fork server. The fork server reports that it is
/// ready, forks a process for each order (see compute_protocol.h), and reports the end of each process. It ends when
/// the other end of `orders` is closed.
///
/// Forked processes outlive the fork server. Each process ends when the server closes its sockets. If the machine runs
/// out of memory, the kernel kills these processes before the server.
[[noreturn]] void run_fork_server(UniqueFd orders, const ComputeProcess& compute);

}  // namespace ccdt::server

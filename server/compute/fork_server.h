#pragma once

#include <functional>

#include "server/compute/compute_protocol.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// The work of a process that computes; it does not return.
using ComputeProcess = std::function<void(ComputeFiles files)>;

/// Says that it is ready, then forks a process for each order that comes, as compute_protocol.h has them, and tells how
/// they end. The calling process, of one thread, becomes it, and ends once the other end of `orders` is closed.
///
/// Processes that are there outlive it: they end with their own sockets. Should the machine run out of memory they go
/// before the server.
[[noreturn]] void run_fork_server(UniqueFd orders, const ComputeProcess& compute);

}  // namespace ccdt::server

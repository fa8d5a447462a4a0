#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "server/monitoring/log.h"

namespace ccdt::server {

/// The signals that a server acts on: SIGINT, SIGTERM and SIGQUIT end it, SIGHUP reloads.
class ServerSignals {
public:
    /// Blocks these signals, and ignores those that would end the program and mean nothing to it. To be made before any
    /// thread: threads inherit the mask, and only the thread that waits takes the signals.
    ServerSignals();

    /// Reloads on each SIGHUP, and returns on the first other signal. From then on a further one ends the program at
    /// once, and SIGHUP is ignored.
    void wait_for_end(const std::function<void()>& reload) const;

private:
    sigset_t signals_;
};

/// Ends the program in time even if a request does not: first nothing is waited for any more, then it is over.
class ShutdownDeadline {
public:
    /// @param abandon  is called shortly before the end
    ShutdownDeadline(std::chrono::milliseconds timeout, std::function<void()> abandon, const Log& log);

private:
    std::jthread thread_;
};

}  // namespace ccdt::server

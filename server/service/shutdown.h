#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "server/monitoring/log.h"

namespace ccdt::server {

/// Signals that end the server, and SIGHUP where it has something to read again: elsewhere that ends the program, as it
/// does when a terminal is closed.
class EndSignals {
public:
    /// Blocks them; to be made before any thread: they inherit the mask, and only the one that waits takes the signals.
    explicit EndSignals(bool reload);

    /// Reloads on SIGHUP, and returns on any other signal. From then on another signal ends the program at once.
    void wait(const std::function<void()>& reload) const;

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

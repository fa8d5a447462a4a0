#pragma once

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <functional>
#include <mutex>
#include <stop_token>
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
    /// Makes the thread that keeps the time, which there may be no memory for when the end begins.
    /// @param abandon  is called shortly before the end
    ShutdownDeadline(std::chrono::milliseconds timeout, std::function<void()> abandon, const Log& log);

    /// Begins to count.
    void start();

private:
    void keep(const std::stop_token& ended);
    bool wait_for_start(const std::stop_token& ended);

    const std::chrono::milliseconds timeout_;
    const std::function<void()> abandon_;
    const Log& log_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    bool started_ = false;  ///< guarded by the mutex
    std::jthread thread_;   ///< last: it uses the others
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
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

/// The signals that the server handles: SIGINT, SIGTERM and SIGQUIT end the server, SIGHUP reloads the key files.
class ServerSignals {
public:
    /// Blocks these signals, and ignores kSignalsWithoutMeaning. Must be constructed before any thread is created, so
    /// that all threads inherit the signal mask.
    ServerSignals();

    /// Calls `reload` on each SIGHUP, and returns on the first other signal. Afterwards, SIGINT, SIGTERM and SIGQUIT
    /// end the program at once, and SIGHUP is ignored.
    void wait_for_end(const std::function<void()>& reload) const;

private:
    sigset_t signals_;
};

/// Ends the program after a time-out, even if clients still wait. Shortly before, calls `abandon`, which answers these
/// clients.
class ShutdownDeadline {
public:
    /// Creates the thread of the timer. Called early, because memory may be lacking at the shutdown.
    /// @param timeout  time between start() and the exit
    /// @param abandon  called a second before the exit
    ShutdownDeadline(std::chrono::milliseconds timeout, std::function<void()> abandon, const Log& log);

    /// Starts the timer.
    void start();

private:
    void enforce(const std::stop_token& ended);
    bool wait_for_start(const std::stop_token& ended);

    const std::chrono::milliseconds timeout_;
    const std::function<void()> abandon_;
    const Log& log_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    bool started_ = false;  ///< guarded by the mutex
    std::jthread thread_;   ///< last, because it uses the other members
};

}  // namespace ccdt::server

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
    /// Blocks these signals, and ignores kSignalsWithoutMeaning. Must be constructed before any thread is created:
    /// threads inherit the mask, so only the thread that waits for the signals receives them.
    ServerSignals();

    /// Calls `reload` on each SIGHUP, and returns on the first other signal. After that, another SIGINT, SIGTERM or
    /// SIGQUIT ends the program at once, and SIGHUP is ignored.
    void wait_for_end(const std::function<void()>& reload) const;

private:
    sigset_t signals_;
};

/// Ends the program in time even if a request does not end: tells all waiting clients that there will be no result,
/// then exits.
class ShutdownDeadline {
public:
    /// Creates the thread now, because memory for it may be lacking later.
    /// @param timeout  time from start() to the exit
    /// @param abandon  called shortly before the exit, to tell the waiting clients
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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace ccdt::server {

/// Runs each task in a separate thread, so that no task waits for another. Creates a thread if none is idle. Otherwise,
/// the task goes to the thread that became idle last. After a peak, the threads that get no more tasks therefore reach
/// their time-out and end. The destructor returns once all tasks are done.
class ConnectionThreads {
public:
    /// @param idle_timeout  time-out of an idle thread
    explicit ConnectionThreads(std::chrono::milliseconds idle_timeout) : idle_timeout_(idle_timeout) {}
    ~ConnectionThreads();

    ConnectionThreads(const ConnectionThreads&) = delete;
    ConnectionThreads& operator=(const ConnectionThreads&) = delete;

    /// Runs a task, which must not throw. Call this from one thread only.
    /// @returns  false if the system has no more threads or memory, or would have too little left; the task is then
    ///           dropped
    bool run(std::function<void()> task);

    struct Counts {
        std::size_t busy = 0;
        std::size_t idle = 0;
    };
    Counts counts() const;

private:
    struct Thread {
        std::function<void()> task;
        std::condition_variable wake;
        std::jthread handle;  ///< last, because it uses the other members
    };
    using Threads = std::list<Thread>;

    void work(Threads::iterator self);

    const std::chrono::milliseconds idle_timeout_;

    /// Guards the members below. After closing_ is set, the threads belong to the destructor.
    mutable std::mutex mutex_;
    bool closing_ = false;
    std::jthread ended_;  ///< the thread that ended last; joined by the next thread that ends
    Threads busy_;
    Threads idle_;  ///< the most recently busy thread is last
};

}  // namespace ccdt::server

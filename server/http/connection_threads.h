#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace ccdt::server {

/// Threads, as many as there are tasks, made when none is idle: no task waits for another. The thread that was busy
/// last takes the next task, so that those of a busy hour get their rest, after which they end. The destructor returns
/// once all tasks are done.
class ConnectionThreads {
public:
    /// @param rest  how long an idle thread is kept
    explicit ConnectionThreads(std::chrono::milliseconds rest) : rest_(rest) {}
    ~ConnectionThreads();

    ConnectionThreads(const ConnectionThreads&) = delete;
    ConnectionThreads& operator=(const ConnectionThreads&) = delete;

    /// Tasks must not throw. From one thread.
    /// @returns  false if the system gives no more threads or memory; the task is then dropped
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
        std::jthread handle;  ///< last: it uses the others
    };
    using Threads = std::list<Thread>;

    void work(Threads::iterator self);

    const std::chrono::milliseconds rest_;

    mutable std::mutex mutex_;  ///< guards the rest; once closing, the threads are the destructor's
    bool closing_ = false;
    std::jthread ended_;  ///< the last that had its rest; joined by the next
    Threads busy_;
    Threads idle_;  ///< who was busy last comes last
};

}  // namespace ccdt::server

#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace ccdt::server {

/// As many threads as there are tasks, made when none is idle and kept for the next task: no task waits for another.
/// The destructor returns once all tasks are done.
class ConnectionThreads {
public:
    /// Tasks must not throw.
    /// @returns  false if the system gives no more threads or memory; the task is then dropped
    bool run(std::function<void()> task);

private:
    void work(const std::stop_token& closing);

    std::mutex mutex_;  ///< guards `tasks_` and `idle_`
    std::condition_variable_any task_waits_;
    std::deque<std::function<void()>> tasks_;
    std::size_t idle_ = 0;

    std::vector<std::jthread> threads_;  ///< last: they use all the rest. Belongs to the thread that calls `run`
};

}  // namespace ccdt::server

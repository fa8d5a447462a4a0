// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Runs tasks on several threads: the caller's thread, and others that are started when first needed and end with this
/// object. Only one thread may call run() at a time.
class ThreadExecutor : public Executor {
public:
    /// @param size  called before each run, on the caller's thread: returns the number of threads to use, the caller's
    ///              included; less than 1 counts as 1
    explicit ThreadExecutor(std::function<std::size_t()> size);
    explicit ThreadExecutor(std::size_t size);
    ThreadExecutor(const ThreadExecutor&) = delete;
    ThreadExecutor& operator=(const ThreadExecutor&) = delete;
    ~ThreadExecutor() override;

    /// Uses the threads that exist if no more can be started.
    void run(std::size_t count, const std::function<void(std::size_t)>& task) override;

private:
    /// State of one call of run().
    struct Work {
        std::size_t count = 0;
        const std::function<void(std::size_t)>* task = nullptr;
        std::atomic<std::size_t> next = 0;  ///< next task to begin
        std::mutex failing;                 ///< guards `failed` and `failure`
        std::size_t failed = 0;             ///< lowest number of a task that threw
        std::exception_ptr failure;
    };

    void start_helpers(std::size_t helpers);
    void help(const std::stop_token& stop);
    static void work_on(Work& work);

    std::function<std::size_t()> size_;
    std::mutex mutex_;
    std::condition_variable_any wanted_;  ///< signals new work
    std::condition_variable left_;        ///< signals that a helper is no longer busy
    Work* work_ = nullptr;
    std::atomic<std::size_t> round_ = 0;  ///< number of calls of run() so far that needed helpers
    std::size_t open_slots_ = 0;          ///< number of helpers that may still join the current work
    std::atomic<std::size_t> busy_ = 0;   ///< number of helpers at work
    std::vector<std::jthread> helpers_;
};

}  // namespace ccdt

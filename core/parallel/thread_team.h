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

#include "core/parallel/team.h"

namespace ccdt {

/// A team of threads: the caller's, and others, which are made when they are first wanted and end with the team. One
/// caller at a time.
class ThreadTeam : public Team {
public:
    /// @param size  asked before each run: how many threads it may have, the caller's among them; fewer than 1 count as
    ///              1. Called by the caller's thread.
    explicit ThreadTeam(std::function<std::size_t()> size);
    explicit ThreadTeam(std::size_t size);
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;
    ~ThreadTeam() override;

    /// Where no further thread can be had, those that there are do the tasks.
    void run(std::size_t count, const std::function<void(std::size_t)>& task) override;

private:
    /// One call of run().
    struct Work {
        std::size_t count = 0;
        const std::function<void(std::size_t)>* task = nullptr;
        std::atomic<std::size_t> next = 0;  ///< task that nobody has begun
        std::mutex failing;
        std::size_t failed = 0;  ///< lowest number of a task that threw
        std::exception_ptr failure;
    };

    void hire(std::size_t helpers);
    void help(const std::stop_token& stop);
    static void work_on(Work& work);

    std::function<std::size_t()> size_;
    std::mutex mutex_;
    std::condition_variable_any wanted_;  ///< there is work
    std::condition_variable left_;        ///< a helper has left it
    Work* work_ = nullptr;
    std::atomic<std::size_t> round_ = 0;  ///< number of the work
    std::size_t places_ = 0;              ///< helpers that may still join it
    std::atomic<std::size_t> busy_ = 0;   ///< helpers at it
    std::vector<std::jthread> helpers_;
};

}  // namespace ccdt

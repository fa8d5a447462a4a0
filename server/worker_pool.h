#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

namespace ccdt::server {

/// A fixed number of threads that do all computing, behind a queue that can say no.
///
/// All members may be called from any thread, jobs included.
class WorkerPool {
public:
    /// Whoever submits a job keeps its result; a job that throws is dropped.
    using Job = std::function<void(std::stop_token)>;
    using JobId = std::uint64_t;
    using Clock = std::chrono::steady_clock;

    /// What became of a job that was cancelled.
    enum class Cancelled { Queued, Running, Unknown };

    /// @param workers   >= 1
    /// @param capacity  jobs that may wait while all workers are busy
    WorkerPool(std::size_t workers, std::size_t capacity);

    /// Tells running jobs to stop and drops those that wait; `drain` first to have all of them done.
    ~WorkerPool();

    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// None: the queue is full.
    std::optional<JobId> submit(Job job);

    /// A waiting job is forgotten, a running one has its stop token set; any other id does nothing.
    Cancelled cancel(JobId id);

    /// A job submitted now would be refused.
    bool is_full() const;

    /// Returns once every job that was submitted is done.
    void drain();

    /// How long the jobs now waiting will keep the workers busy, at the pace of late; at least a second.
    std::chrono::seconds backlog() const;

private:
    struct Waiting {
        JobId id = 0;
        Job job;
    };
    struct Running {
        std::stop_source stop;
        Clock::time_point started;
    };

    void work(const std::stop_token& closing);
    static void run(const Job& job, const std::stop_token& stop);
    bool is_full_locked() const;
    double expected_seconds_locked() const;

    const std::size_t worker_count_;
    const std::size_t capacity_;

    mutable std::mutex mutex_;  ///< guards the members from here to `average_seconds_`
    std::condition_variable_any job_waits_;
    std::condition_variable idle_;
    std::deque<Waiting> waiting_;
    std::map<JobId, Running> running_;
    JobId last_id_ = 0;
    double average_seconds_ = 0;  ///< of a job, the last ones weighing most; 0 before the first

    std::vector<std::jthread> workers_;  ///< last: they use all the rest
};

}  // namespace ccdt::server

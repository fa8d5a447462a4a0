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
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace ccdt::server {

/// A fixed number of threads that do all computing, behind a queue that can say no.
///
/// Clients take turns: each one's first waiting job goes before any one's second, whenever they came, and a client
/// without a waiting job is let in even where others have filled the queue, until it is twice as long. So a hundred
/// jobs of one client keep another's only one waiting no longer than those that run.
///
/// All members may be called from any thread, jobs included.
/// Source: Goyal, Vin, Cheng 1996, Start-time fair queuing, every job costing the same.
class WorkerPool {
public:
    /// Whoever submits a job keeps its result; a job that throws is dropped.
    using Job = std::function<void(std::stop_token)>;
    using JobId = std::uint64_t;
    using Clock = std::chrono::steady_clock;

    /// What became of a job that was cancelled.
    enum class Cancelled { Queued, Running, Unknown };

    struct Load {
        std::size_t workers = 0;
        std::size_t busy = 0;        ///< of them
        std::size_t waiting = 0;     ///< jobs
        std::size_t capacity = 0;    ///< jobs that may wait
        double oldest_seconds = 0;   ///< that a job has waited
        double backlog_seconds = 0;  ///< until those that wait are done, at the pace of late; 0 if none waits
        double overdue_seconds = 0;  ///< that a job has gone on after it was cancelled
    };

    /// @param workers   >= 1
    /// @param capacity  jobs that may wait while all workers are busy
    WorkerPool(std::size_t workers, std::size_t capacity);

    /// Tells running jobs to stop and drops those that wait; `drain` first to have all of them done.
    ~WorkerPool();

    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// @param client  whose turn it takes; any name
    /// @returns       none: the queue is full
    std::optional<JobId> submit(const std::string& client, Job job);

    /// A waiting job is forgotten, a running one has its stop token set; any other id does nothing.
    Cancelled cancel(JobId id);

    /// A job that the client submits now would be refused.
    bool is_full(std::string_view client) const;

    /// Returns once every job that was submitted is done.
    void drain();

    Load load() const;

    /// How long the jobs now waiting will keep the workers busy, at the pace of late; at least a second.
    std::chrono::seconds backlog() const;

private:
    struct Waiting {
        JobId id = 0;
        std::string client;
        std::uint64_t turn = 0;
        Clock::time_point came;
        Job job;
    };
    struct Running {
        std::stop_source stop;
        Clock::time_point started;
        std::optional<Clock::time_point> cancelled = {};
    };

    void work(const std::stop_token& closing);
    static void run(const Job& job, const std::stop_token& stop);
    bool is_full_locked(std::string_view client) const;
    std::uint64_t next_turn_locked(std::string_view client) const;
    Waiting take_next_locked();
    double expected_seconds_locked() const;

    const std::size_t worker_count_;
    const std::size_t capacity_;

    mutable std::mutex mutex_;  ///< guards the members from here to `average_seconds_`
    std::condition_variable_any job_waits_;
    std::condition_variable idle_;
    std::deque<Waiting> waiting_;  ///< in the order in which they came
    std::uint64_t turn_ = 0;       ///< of the job that began last
    std::map<JobId, Running> running_;
    JobId last_id_ = 0;
    double average_seconds_ = 0;  ///< of a job, the last ones weighing most; 0 before the first

    std::vector<std::jthread> workers_;  ///< last: they use all the rest
};

}  // namespace ccdt::server

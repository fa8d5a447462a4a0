// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "api/run/options.h"
#include "server/pool/fair_queue.h"
#include "server/pool/memory_budget.h"

namespace ccdt::server {

/// A fixed number of threads that run all computations, with bounded queues.
///
/// The queues are fair between clients (FairQueue), by the processor time of jobs, which is estimated until a job has
/// ended. A client without a waiting job is admitted to a full queue, until the queue is twice as long as its limit. So
/// one client's hundred waiting jobs do not delay a single job of another client. Short jobs have a separate queue and
/// one additional slot, so that they need not wait for long ones.
///
/// A job whose estimate was too low leaves the slot of short jobs after kOverrun, and another thread runs the next
/// short job. As many of these jobs as there are workers may continue beside the workers. Beyond that number, the pool
/// displaces one of them, and its owner submits it again as a long job.
///
/// A job starts only when its estimated memory is available. Until then, the next jobs of the same queue wait, too.
/// Otherwise, a large job might never start.
///
/// Thread-safe; jobs may call all members.
class WorkerPool {
public:
    using JobId = std::uint64_t;
    using Clock = std::chrono::steady_clock;

    /// The stop token that a running job receives, and the processor time that it reports.
    struct Turn {
        std::stop_token stop;
        double used = 0;  ///< processor time in seconds, set by the job; 0: unknown, the elapsed time is charged

        operator const std::stop_token&() const { return stop; }
    };

    /// The function of a job. It must deliver its own result. Exceptions from it are ignored.
    using Job = std::function<void(Turn&)>;

    /// Tells the owner of a running job that the pool stops the job, so that the owner submits it again as a long job.
    /// Must return quickly, and must not use the pool.
    /// @returns  false if that is not possible, because the delivery of the result has begun
    using Displace = std::function<bool()>;

    /// State of a job when it was cancelled.
    enum class Cancelled { Queued, Running, Unknown };

    struct Load {
        std::size_t workers = 0;
        std::size_t busy = 0;        ///< threads that run a job; at most max_computations(workers)
        std::size_t waiting = 0;     ///< waiting jobs
        std::size_t capacity = 0;    ///< limit of waiting jobs
        double oldest_seconds = 0;   ///< longest time that a waiting job has waited so far
        double backlog_seconds = 0;  ///< estimated time until all waiting jobs have started
        double overdue_seconds = 0;  ///< longest time that a running job has continued after its cancellation
    };

    /// Limit of the estimated duration of short jobs, in seconds.
    static constexpr double kShort = 0.02;

    /// Time after which a job leaves the slot of short jobs. Other short jobs wait at most this long for a job whose
    /// estimate was too low.
    static constexpr std::chrono::milliseconds kOverrun{50};

    /// Nice value of the threads that run long jobs. Beside a short job, a long one receives a quarter of a processor.
    /// A higher value starves long jobs beside other programs: measured with four of them per processor, a picture of
    /// 0.25 s of processor time took 15 s with 10, and 5 s with 5. Short jobs were answered equally fast.
    static constexpr int kNiceOfLong = 5;

    /// @param workers   >= 1
    /// @param capacity  limit of waiting jobs while all workers are busy, separately for short and long jobs
    /// @param memory    limit of the estimated memory of running jobs, in bytes
    WorkerPool(std::size_t workers, std::size_t capacity, std::size_t memory = std::numeric_limits<std::size_t>::max());

    /// Stops running jobs and drops waiting ones. To finish all jobs, call `drain` first.
    ~WorkerPool();

    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Submits a job.
    /// @param client    name of the client, for fair queueing
    /// @param cost      estimated cost; its memory must not exceed the limit of the pool
    /// @param displace  empty: the job cannot be displaced
    /// @returns         none if the queue is full
    std::optional<JobId> submit(const std::string& client, Job job, const api::Cost& cost = {0, 1},
                                Displace displace = {});

    /// Submits a job even if the queue is full. The caller limits the number of such jobs.
    JobId submit_always(const std::string& client, Job job, const api::Cost& cost);

    /// Drops a waiting job, or requests a running one to stop. Ignores unknown ids.
    Cancelled cancel(JobId id);

    /// Whether submit() would now refuse a job of this client: a long one and, if `may_be_short`, also a short one.
    bool is_full(std::string_view client, bool may_be_short = true) const;

    /// Sets a function that is called with the number of running jobs whenever that number changes. The function must
    /// return quickly. Must be called before the first job is submitted.
    void on_change(std::function<void(std::size_t running)> callback) { callback_ = std::move(callback); }

    /// Returns the memory budget of running jobs.
    MemoryBudget& memory() { return memory_; }
    const MemoryBudget& memory() const { return memory_; }

    /// Waits until all submitted jobs are done.
    void drain();

    Load load() const;

    /// Estimates the time until a job submitted now would start, from the recent speed of jobs; 1 s to 1 h.
    std::chrono::seconds backlog() const;

private:
    /// The jobs that a thread runs: all, or short ones only. Jobs leave the lane Short to Overrun, and Overrun to
    /// Displaced.
    enum class Lane { Any, Short, Overrun, Displaced };

    struct Waiting {
        JobId id = 0;
        std::string client;
        std::uint64_t generation = 0;  ///< of its queue
        api::Cost cost;
        Clock::time_point came;
        Job job;
        Displace displace;
    };
    struct Running {
        std::stop_source stop;
        std::string client;
        std::uint64_t generation = 0;
        Displace displace;
        Lane lane{};
        double expected = 0;  ///< in seconds
        Clock::time_point started;
        std::optional<Clock::time_point> cancelled = {};
    };

    using Queue = FairQueue<Waiting>;

    void work(Lane lane, const std::stop_token& closing);
    static void run(const Job& job, Turn& turn);
    void watch_short_lane(const std::stop_token& closing);
    void leave_short_lane_locked();
    void wake_all_locked();
    JobId push_locked(const std::string& client, Job job, const api::Cost& cost, Displace displace);
    Queue& queue_of(double seconds) { return seconds <= kShort ? short_ : long_; }
    std::size_t count_locked(Lane lane) const;
    bool accepts_locked(std::string_view client, bool is_short) const;
    std::size_t waiting_locked() const { return long_.size() + short_.size(); }
    bool is_idle_locked() const { return waiting_locked() == 0 && running_.empty(); }
    std::optional<Waiting> take_job_locked(Lane lane, std::optional<MemoryBudget::Lease>& memory);
    std::stop_token begin_locked(Waiting& job, Lane lane);
    void finish_locked(JobId id, double used);
    double waiting_seconds_locked() const;

    const std::size_t worker_count_;
    const std::size_t capacity_;

    MemoryBudget memory_;
    std::function<void(std::size_t running)> callback_ = [](std::size_t) {};

    mutable std::mutex mutex_;                     ///< guards the members from here to `pace_`
    std::condition_variable_any job_waits_;        ///< for the threads of the lane Any
    std::condition_variable_any short_job_waits_;  ///< for the threads of the lane Short
    std::condition_variable_any short_lane_used_;  ///< for the thread that watches the lane Short
    std::condition_variable idle_;
    Queue long_;
    Queue short_;
    std::map<JobId, Running> running_;
    std::optional<JobId> in_short_lane_;  ///< the running job in the lane Short
    bool watched_ = false;                ///< the watching thread will look at the lane Short again by itself
    JobId last_id_ = 0;
    double pace_ = 1;  ///< actual / estimated duration of jobs: a running average

    std::vector<std::jthread> threads_;  ///< last, because they use all other members
};

}  // namespace ccdt::server

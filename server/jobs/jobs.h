#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/http/http.h"
#include "server/http/problem.h"
#include "server/jobs/job.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_store.h"
#include "server/work/computation.h"
#include "server/work/fair_queue.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// A job that has ended, for log and figures.
struct JobEnd {
    Job job;
    Stages stages;
    std::optional<Computed> computed;
    std::string cause;  ///< of a failure of ours
};

/// Runs jobs: requests whose clients do not wait.
///
/// What was accepted is in the store, and ends in a result, a failure or a cancellation that is in the store as well. A
/// job waits in a queue of its own, in which clients take turns, and is handed to the pool when its turn comes. There
/// it competes with the requests that are waited for; jobs have at most all workers but one, and at least one.
///
/// A job has `timeout` from the start of its run, and is forgotten `ttl` after its end. To make room for jobs and
/// results, the results that are oldest are dropped, their jobs staying. May be used from any thread.
class Jobs {
    struct Live;

public:
    using Clock = std::chrono::steady_clock;
    using Logger = std::function<void(const JobEnd&)>;

    /// @param survives  the store outlives the process: what is not done when it drains is done by the next one
    /// The others must outlive it.
    Jobs(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger);

    /// Stops what runs.
    ~Jobs();

    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    /// Begins to run jobs, first those that the store has from before.
    /// Errors: those of the store.
    Result<void> start();

    /// Whether a job that the client submits now would be refused.
    bool is_full(std::string_view client) const;

    /// Takes on a job; once this returns it will not be lost.
    ///
    /// @param job  whose it is, and what it costs, which the pool has room for
    /// Problems: 413 larger than the store, 429 the queue is full, or the store of what waits, 503 the server shuts
    /// down, 507 and 500 the store fails.
    HttpResult<Job> accept(Job job, const ComputeRequest& request);

    /// Finds a job. Problems, of the following too: 404 there is no such job, or it is somebody else's; 500 the store
    /// fails.
    HttpResult<Job> find(const std::string& id, const std::string& owner) const;

    /// The result of a job that has succeeded. Problems: 410 it was dropped to make room, or the job is gone.
    HttpResult<std::string> result(const std::string& id);

    /// Cancels a job that has not finished, and forgets one that has.
    HttpResult<void> remove(const std::string& id, const std::string& owner);

    /// Follows a job.
    class Watch {
    public:
        /// Waits for news: first where the job stands, then each iteration, in the end how it ended.
        /// @returns  none if there was none until then
        std::optional<Job> next(Clock::time_point until);

    private:
        friend class Jobs;
        Watch(const Jobs& jobs, std::shared_ptr<Live> live) : jobs_(jobs), live_(std::move(live)) {}

        const Jobs& jobs_;
        const std::shared_ptr<Live> live_;
        std::optional<std::size_t> seen_;  ///< iterations
        bool over_ = false;
    };
    HttpResult<Watch> watch(const std::string& id, const std::string& owner) const;

    /// Accepts no more and stops what runs; returns at once. If the store survives, what is not done is for the next
    /// server; else it fails.
    void drain();
    bool is_draining() const;

    struct Counts {
        std::size_t queued = 0;
        std::size_t running = 0;
    };
    Counts counts() const;
    std::size_t stored_bytes() const { return store_.bytes(); }

private:
    /// Reasons to stop a run.
    enum class Stop { None, Deadline, Shutdown };

    /// A job that has not finished, or whose end could not be stored.
    struct Live {
        Job job;
        std::vector<JobProgress> steps;
        std::optional<WorkerPool::JobId> handed;  ///< to the pool
        std::optional<Clock::time_point> deadline;
        Stop stop = Stop::None;
        bool settling = false;  ///< whoever has set it stores how the job ends; nobody else does
        std::condition_variable changed;
    };
    using LivePointer = std::shared_ptr<Live>;

    /// The outcome of a run.
    struct Run {
        Result<api::Answer> answer;
        Stages stages;
    };

    LivePointer find_live_locked(const std::string& id, const std::string& owner) const;
    bool has_room_locked(std::string_view client) const;
    HttpResult<void> store_new(const Job& job, const ComputeRequest& request);
    bool make_room(std::size_t bytes);
    void take_up(Job job);
    void admit_locked(Job job);
    void feed_locked();
    void hand_next_locked();
    void run(const LivePointer& live, const std::stop_token& stop);
    std::optional<Job> begin(const LivePointer& live);
    Run compute(const Job& job, const LivePointer& live, const std::stop_token& stop);
    Result<ComputeRequest> load_request(const std::string& id) const;
    void note(const LivePointer& live, const Progress& progress);
    void finish_run(const LivePointer& live, Run run);
    bool withdraw_locked(Live& live);
    void settle(const LivePointer& live, Job job, std::string result, JobEnd end);
    Result<void> store_end(Job& job, std::string_view result);
    void fail(const LivePointer& live, Problem failure);
    void keep_time(const std::stop_token& closing);
    std::optional<Clock::time_point> stop_overdue_locked();
    std::optional<Time> forget_expired();

    const JobLimits limits_;
    JobStore& store_;
    const bool survives_;
    WorkerPool& pool_;
    const Compute compute_;
    const Logger logger_;
    const std::size_t at_once_;  ///< jobs that the pool is handed

    std::mutex room_;  ///< held while room is made and used

    mutable std::mutex mutex_;  ///< guards the members from here to `draining_`
    std::condition_variable idle_;
    std::condition_variable_any wake_timekeeper_;
    bool news_ = false;  ///< for the timekeeper: a deadline or an expiry
    std::map<std::string, LivePointer> live_;
    FairQueue<LivePointer> queue_;
    std::size_t arriving_ = 0;  ///< being stored
    std::size_t handed_ = 0;    ///< to the pool
    bool started_ = false;
    bool draining_ = false;

    std::jthread timekeeper_;  ///< stops runs at their deadlines, forgets jobs; last: it uses all the rest
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/http/http.h"
#include "server/http/problem.h"
#include "server/jobs/followed_jobs.h"
#include "server/jobs/job.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_store.h"
#include "server/work/computation.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// A finished job, for the log and the metrics.
struct JobEnd {
    Job job;
    Stages stages;
    std::optional<Computed> computed;
    std::string cause;  ///< cause of an internal failure
};

/// Runs jobs: requests whose clients do not wait.
///
/// The store holds all accepted jobs, and how they ended: a result, a failure or a cancellation. A job waits in the
/// queue of the store, which is fair between clients. When the job is next and the pool can accept it, the job is
/// claimed and passed to the pool. In the pool, jobs compete with requests whose clients wait. With several workers,
/// fewer jobs than workers are in the pool at a time, so that jobs cannot occupy all workers. If servers share a store,
/// each runs the jobs that it has claimed, and answers requests about all jobs.
///
/// A job may run for `timeout`, and is deleted `ttl` after its end. Thread-safe.
class Jobs : private JobListener {
public:
    using Clock = std::chrono::steady_clock;
    using Logger = std::function<void(const JobEnd&)>;

    /// Events of this server's runs.
    struct Counts {
        std::uint64_t lost = 0;      ///< runs given up because another server had claimed the job
        std::uint64_t repeated = 0;  ///< runs of jobs that an earlier run had not finished
    };

    /// @param survives  whether the store outlives the process; if so, unfinished jobs are left to the next process
    /// The references must outlive this object. The store must have no other listener.
    Jobs(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger);

    /// Stops all runs.
    ~Jobs() override;

    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    /// Starts to run jobs, including those already in the store.
    void start();

    /// Whether a job submitted by this client would be refused now.
    bool is_full(std::string_view client) const;

    /// Accepts a job. Once this returns, the job will not be lost.
    ///
    /// @param job  with owner and cost; the cost must fit into the pool
    /// Problems: 413 the job or its result exceeds the capacity of the store; 429 the queue is full, or waiting jobs
    /// fill the store; 503 the server is shutting down, or the store cannot be reached; 507 the store has no space; 500
    /// the store fails.
    HttpResult<Job> accept(Job job, const ComputeRequest& request);

    /// Finds a job.
    /// Problems, also of the functions below: 404 the job does not exist or has another owner; 503 the store cannot be
    /// reached; 500 the store fails.
    HttpResult<Job> find(const std::string& id, const std::string& owner) const;

    /// Reads the result of a job that has succeeded.
    /// Problems: 410 the result was dropped to free space, or the job is gone.
    HttpResult<std::string> result(const std::string& id);

    /// Reads a piece of the result: see JobStore::piece.
    /// Problems: those of result().
    HttpResult<std::string> piece(const std::string& id, std::size_t number);

    /// Cancels a job that has not ended, or deletes one that has.
    HttpResult<void> remove(const std::string& id, const std::string& owner);

    using Watch = JobWatch;

    /// Follows a job's progress.
    HttpResult<Watch> watch(const std::string& id, const std::string& owner);

    /// Stops all runs, and returns at once. If the store survives, unfinished jobs are left to the next process or to
    /// other servers. Otherwise unfinished jobs fail, and no more jobs are accepted.
    void drain();
    bool is_draining() const;

    /// Counts the jobs of all servers that share the store; none if the store cannot be reached.
    std::optional<JobStore::Load> load() const;
    Counts counts() const;

private:
    /// Why a run is stopped.
    enum class Stop { None, Deadline, Shutdown, Gone };

    /// The end of a job, to be stored.
    struct End {
        std::string result;
        JobEnd summary;
        JobStore::StoredPart before = {};  ///< part of the result that the store already has, before `result`
    };
    class ResultWriter;

    /// A job that this server has claimed.
    struct Run {
        Job job;
        std::optional<WorkerPool::JobId> pool_id;  ///< id of the job in the pool; none: not in the pool
        std::optional<Clock::time_point> deadline;
        Stop stop = Stop::None;
        std::stop_source unneeded;    ///< stopped once nobody needs the result
        Clock::time_point renewed;    ///< time of the latest attempt to renew the lease
        bool progress_stored = true;  ///< the store has the latest progress
        bool settling = false;        ///< set by the thread that stores the job's end; no other thread does so
        std::optional<End> unstored;  ///< an end that could not be stored yet
    };
    using RunPointer = std::shared_ptr<Run>;

    void work() override;
    void changed(const std::string& id) override;
    void stop(const std::string& id) override;
    void missed() override;

    HttpResult<void> add(Job& job, const ComputeRequest& request);
    void hand_out(const std::stop_token& closing);
    bool claim_next();
    void submit(Job job);
    void run(const RunPointer& run, const std::stop_token& stop);
    bool begin(const RunPointer& run);
    std::optional<End> compute(const RunPointer& run, const std::stop_token& stop);
    End end_of(Job job, Result<api::Answer> answer, ResultWriter& writer, const Stages& stages) const;
    void note(const RunPointer& run, const Progress& progress);
    void requeue(const RunPointer& run);
    void settle(const RunPointer& run, End end);
    Result<std::optional<Time>> store_end(End& end);
    void fail_all();

    bool stop_locked(Run& run, Stop why);
    bool check_owned_locked(const RunPointer& run, JobStore::Owned owned);
    void drop_locked(const RunPointer& run);
    void erase_locked(const RunPointer& run);
    void release_locked();
    std::size_t count_unstored_locked() const;

    void add_latest(Job& job) const;
    void look_again(const std::string& id, FollowedJob& followed) const;

    void keep_time(const std::stop_token& closing);
    Clock::time_point stop_overdue_locked();
    Clock::time_point next_renewal_locked(const Run& run) const;
    Clock::time_point next_renewal_locked() const;
    void renew_leases();
    void store_remaining_ends();

    const JobLimits limits_;
    JobStore& store_;
    const bool survives_;
    WorkerPool& pool_;
    const Compute compute_;
    const Logger logger_;
    const std::size_t at_once_;  ///< limit of jobs in the pool at a time
    FollowedJobs followed_;

    mutable std::mutex mutex_;  ///< guards the members up to `draining_`; released while the store is used
    std::condition_variable idle_;
    std::condition_variable_any wake_claimer_;
    std::condition_variable_any wake_timekeeper_;
    bool has_work_ = false;      ///< the claimer should look for a job in the store
    bool runs_changed_ = false;  ///< runs have changed since the timekeeper last looked at them
    std::map<std::string, RunPointer> runs_;
    std::size_t in_pool_ = 0;  ///< number of jobs in the pool
    Counts counts_;
    bool started_ = false;
    bool draining_ = false;

    std::jthread claimer_;     ///< claims jobs; the two threads come last, because they use all other members
    std::jthread timekeeper_;  ///< stops runs at their deadlines, renews leases, deletes expired jobs
};

}  // namespace ccdt::server

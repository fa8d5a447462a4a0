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
#include <utility>
#include <vector>

#include "core/ccdt/plane/ccdt.h"
#include "server/jobs/job.h"
#include "server/jobs/job_store.h"
#include "server/pool/worker_pool.h"

namespace ccdt::server {

/// A finished job, and facts about its last run, for the log and the metrics.
struct JobEnd {
    Job job;
    Stages stages;
    std::optional<Computed> computed;
    std::string cause;  ///< cause of an internal failure, or doubt about the answer
};

/// This server's run of a job that it has claimed. Thread-safe.
class JobRun {
public:
    using Clock = std::chrono::steady_clock;

    /// The end of a job, before it is stored.
    struct End {
        std::string result;
        JobEnd summary;
        JobStore::StoredPart before = {};  ///< part of the result that is already stored; `result` is the rest
    };

    /// The reason why a run is stopped. Gone: the job was cancelled, or another server has claimed it.
    enum class Stop { None, Deadline, Shutdown, Gone };

    /// The next step of the caller. Proceed: compute the result after begin(), or store the end after finish().
    enum class Next { Proceed, Requeue, Nothing };

    explicit JobRun(Job job) : job_(std::move(job)) {}

    Job job() const;
    bool is_gone() const;

    /// Returns a token that requests a stop when the result is no longer needed.
    std::stop_token unneeded() const { return unneeded_.get_token(); }

    /// Returns the id of the job in the pool; none: not in the pool.
    std::optional<WorkerPool::JobId> pool_id() const;

    /// Calls `submit`, which passes the job to the pool and returns its id there. Calls of stop() wait meanwhile.
    void enter_pool(const std::function<WorkerPool::JobId()>& submit);

    /// Marks the run as begun.
    /// @param renewal  result of JobStore::renew()
    /// @param timeout  time limit of the run
    Next begin(const Result<JobStore::Renewal>& renewal, Clock::duration timeout);

    /// Records progress.
    /// @returns  whether the store contains the previously recorded progress
    bool note(const Progress& progress);

    /// Records that the computation has ended.
    /// @param whole   false if the computation was stopped early
    /// @param repeat  true if it failed, and the job should run again
    Next finish(bool whole, bool repeat);

    /// Records that the run has to stop.
    /// @returns  false if the end of the job is being stored, or the run was given up
    bool stop(Stop why);

    /// Stops the run, because this server does not own the job any more.
    /// @returns  false if stop() would return false
    bool give_up(JobStore::Owned owned);

    /// Gives the calling thread the sole right to store how the job ended.
    /// @returns  false if another thread has the right
    bool start_settling();

    /// Keeps the end of the job for a later attempt to store it.
    void keep_end(End end);
    bool has_end() const;
    std::optional<End> take_end();

    bool is_overdue() const;

    /// Returns the next time at which the result of is_overdue() or take_due() may change.
    /// @param interval  pause between renewals of the lease
    Clock::time_point next_due(Clock::duration interval) const;

    /// Returns the job for JobStore::renew() if the lease must be renewed or new progress must be stored; otherwise
    /// none.
    /// @param interval  pause between renewals of the lease
    std::optional<Job> take_due(Clock::duration interval);

    /// Records that JobStore::renew() was called with the job that take_due() returned.
    /// @param stored  false if the store failed
    void renewed(bool stored);

    /// Records that the store may not have the latest progress.
    void forget_stored_progress();

    /// Updates `job`, which was read from the store, with progress that is not stored yet.
    void add_latest(Job& job) const;

private:
    Clock::time_point next_renewal_locked(Clock::duration interval) const;

    std::stop_source unneeded_;

    mutable std::mutex mutex_;  ///< guards the members below
    Job job_;
    std::optional<WorkerPool::JobId> pool_id_;
    std::optional<Clock::time_point> deadline_;
    Stop stop_ = Stop::None;
    Clock::time_point renewed_ = Clock::now();  ///< latest attempt to renew the lease
    bool progress_stored_ = true;               ///< the store has the latest progress
    bool settling_ = false;                     ///< the end of the job is being stored
    std::optional<End> end_;                    ///< end that could not be stored yet
};

/// The runs of all jobs that this server has claimed. Thread-safe.
class ClaimedRuns {
public:
    using Clock = JobRun::Clock;
    using Run = std::shared_ptr<JobRun>;

    /// Numbers of events since the start.
    struct Counts {
        std::uint64_t lost = 0;      ///< runs given up because another server had claimed the job
        std::uint64_t repeated = 0;  ///< runs of jobs that an earlier run had not finished
    };

    /// @param at_once  maximum number of jobs in the pool at the same time
    explicit ClaimedRuns(std::size_t at_once) : at_once_(at_once) {}

    void start();

    /// Stops passing jobs to the pool.
    /// @returns  all runs at the first call; an empty list at later calls
    std::vector<Run> drain();
    bool is_draining() const;

    /// Whether another job may be claimed.
    bool may_claim() const;

    /// Adds a run.
    /// @param for_pool  whether the job should be passed to the pool
    /// @returns         whether the caller must pass the job to the pool; if so, leave_pool() must be called after the
    ///                  job's run
    bool add(const Run& run, bool for_pool);
    void leave_pool();
    void wait_until_pool_is_left();

    void erase(const Run& run);

    /// Returns the run of a job; null if this server has not claimed the job.
    Run find(const std::string& id) const;
    std::vector<Run> all() const;

    void count_lost();
    Counts counts() const;

    /// Makes wait_for_work() return.
    void wake_claimer();

    /// Waits until wake_claimer() is called, or for the duration `pause`.
    void wait_for_work(const std::stop_token& closing, Clock::duration pause);

    /// Makes wait_for_change() return. Called when runs have changed.
    void wake_timekeeper();
    void wait_for_change(const std::stop_token& closing, Clock::time_point until);

private:
    const std::size_t at_once_;

    mutable std::mutex mutex_;  ///< guards the members below; locked before the mutex of a JobRun
    std::condition_variable_any wake_;
    bool has_work_ = false;  ///< wake_claimer() was called
    bool changed_ = false;   ///< wake_timekeeper() was called
    std::map<std::string, Run> runs_;
    std::size_t in_pool_ = 0;  ///< number of jobs in the pool
    Counts counts_;
    bool started_ = false;
    bool draining_ = false;
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "core/base/result.h"
#include "server/jobs/claimed_runs.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_store.h"
#include "server/jobs/watched_jobs.h"
#include "server/pool/worker_pool.h"
#include "server/requests/compute.h"

namespace ccdt::server {

/// Claims jobs of a store, and runs them in the pool.
///
/// Jobs wait in the queue of the store, which is fair between clients. Whenever the pool has capacity for a job, the
/// next one is claimed and passed to the pool. There, jobs compete with requests whose clients wait. Thread-safe.
class JobRunner {
public:
    using Logger = std::function<void(const JobEnd&)>;

    /// Maximum time until this server notices an expired lease of another server, or the end of an outage of the store.
    static constexpr std::chrono::milliseconds kPollInterval{1000};

    /// Takes the same parameters as the constructor of Jobs; `watched` receives the states of the jobs.
    JobRunner(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger,
              WatchedJobs& watched);

    /// Stops all runs.
    ~JobRunner();

    JobRunner(const JobRunner&) = delete;
    JobRunner& operator=(const JobRunner&) = delete;

    void start() { runs_.start(); }

    /// Stops all runs, as described for JobService::drain.
    void drain();
    bool is_draining() const { return runs_.is_draining(); }

    /// Fails all jobs in the store that can be claimed: jobs that wait, and jobs whose leases have expired.
    void fail_all();

    /// Makes the claiming thread look for jobs.
    void claim() { runs_.wake_claimer(); }

    /// Stops and forgets this server's run of a cancelled job, if any.
    void drop(const std::string& id);

    /// Stores the progress of all runs, and looks for jobs to claim.
    void refresh();

    /// Updates a job that was read from the store with progress that is not stored yet, if this server runs the job.
    void add_latest(Job& job) const;

    ClaimedRuns::Counts counts() const { return runs_.counts(); }

private:
    using Run = ClaimedRuns::Run;
    class ResultWriter;

    void claim_jobs(const std::stop_token& closing);
    bool claim_next();
    void submit(Job job);
    double run(const Run& run, const std::stop_token& stop);
    bool begin_run(const Run& run);
    std::optional<JobRun::End> compute(const Run& run, const std::stop_token& stop);
    JobRun::End end_of(Job job, std::string_view path, Result<api::Answer> answer, ResultWriter& writer,
                       const Stages& stages) const;
    void note(const Run& run, const Progress& progress);
    bool cancel_in_pool(const Run& run);
    void give_up(const Run& run, JobStore::Owned owned);
    void requeue(const Run& run, bool counted = false);
    void settle(const Run& run, JobRun::End end);
    Result<std::optional<Time>> store_end(JobRun::End& end);
    void keep_time(const std::stop_token& closing);
    void renew_leases();
    void store_remaining_ends();

    const JobLimits limits_;
    JobStore& store_;
    const bool survives_;
    WorkerPool& pool_;
    const Compute compute_;
    const Logger logger_;
    WatchedJobs& watched_;
    const std::chrono::milliseconds renewal_interval_;
    ClaimedRuns runs_;

    std::jthread claimer_;     ///< claims jobs; both threads are declared last, because they use all other members
    std::jthread timekeeper_;  ///< stops runs at their deadlines, renews leases, deletes expired jobs
};

}  // namespace ccdt::server

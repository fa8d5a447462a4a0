// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/problem.h"
#include "server/jobs/job.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/job_store.h"
#include "server/jobs/watched_jobs.h"
#include "server/pool/worker_pool.h"
#include "server/requests/compute.h"

namespace ccdt::server {

/// Runs jobs: requests whose clients do not wait.
///
/// The store contains all accepted jobs and their outcomes. If servers share a store, each server runs the jobs that it
/// has claimed (see JobRunner), and answers requests about all jobs. A job may run for `JobLimits::timeout`, and is
/// deleted `JobLimits::ttl` after its end. Thread-safe.
class JobService : private JobListener {
public:
    using Clock = std::chrono::steady_clock;
    using Logger = JobRunner::Logger;
    using Counts = ClaimedRuns::Counts;

    /// @param survives  whether the store outlives this process, so that the next process can run unfinished jobs
    /// The references must outlive this object. The store must have no other listener.
    JobService(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute,
               Logger logger);

    /// Stops all runs.
    ~JobService() override;

    JobService(const JobService&) = delete;
    JobService& operator=(const JobService&) = delete;

    /// Starts to run jobs, including jobs that are already in the store.
    void start() { runner_.start(); }

    /// Whether accept() would now refuse a job of this client, because the queue is full.
    bool is_full(std::string_view client) const;

    /// Stores a job to be run. After success, a durable store keeps the job even if the server ends.
    ///
    /// @param job  job whose owner, client and cost are set; `cost.memory` must not exceed the limit of the pool
    /// Problems: 413 the request or the result is larger than the store; 429 the queue is full, or waiting jobs fill
    /// the store; 503 during a shutdown or an outage of the store; 507 the disk or Redis is full; 500 the store fails.
    HttpResult<Job> accept(Job job, const ComputeRequest& request);

    /// Finds a job.
    /// Problems of this function and the functions below: 404 the job does not exist or has another owner; 503 the
    /// store cannot be reached; 500 the store fails.
    HttpResult<Job> find(const std::string& id, const std::string& owner) const;

    /// Reads the result of a job that has succeeded.
    /// Problems: 410 the result was deleted to free space, or the job no longer exists.
    HttpResult<std::string> result(const std::string& id);

    /// Reads a piece of the result, as JobStore::piece does.
    /// Problems: those of result().
    HttpResult<std::string> piece(const std::string& id, std::size_t number);

    /// Cancels a job that has not ended. Deletes a job that has ended.
    HttpResult<void> remove(const std::string& id, const std::string& owner);

    using Watch = JobWatch;

    /// Follows a job's progress.
    HttpResult<Watch> watch(const std::string& id, const std::string& owner);

    /// Requests all runs to stop, and returns at once. If the store survives, unfinished jobs stay in it for the next
    /// process or other servers. Otherwise, unfinished jobs fail, and no more jobs are accepted.
    void drain() { runner_.drain(); }
    bool is_draining() const { return runner_.is_draining(); }

    /// Counts the jobs of all servers that share the store; none if the store cannot be reached.
    std::optional<JobStore::Load> load() const;
    Counts counts() const { return runner_.counts(); }

private:
    void work() override;
    void changed(const std::string& id) override;
    void stop(const std::string& id) override;
    void missed() override;

    HttpResult<void> add(Job& job, const ComputeRequest& request);
    void look_again(const std::string& id, WatchedJob& watched) const;

    const JobLimits limits_;
    JobStore& store_;
    const bool survives_;
    WorkerPool& pool_;
    const Logger logger_;
    WatchedJobs watched_;
    JobRunner runner_;
};

}  // namespace ccdt::server

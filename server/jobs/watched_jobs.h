// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/job.h"

namespace ccdt::server {

/// A job that clients follow: its latest known state, and its progress after each iteration. Thread-safe.
class WatchedJob {
public:
    /// Updates the state, unless `job` is older than the known state.
    void advance(const Job& job);

    /// Records that the store may have a newer state.
    void mark_stale();

    /// Records that the job no longer exists.
    void mark_gone();

private:
    friend class JobWatch;

    std::mutex mutex_;  ///< guards all other members
    std::condition_variable changed_;
    Job job_;
    std::vector<JobProgress> steps_;
    bool stale_ = false;
    bool gone_ = false;
};

/// Follows the progress of a job for one client.
class JobWatch {
public:
    /// Updates `job` with the state in the store, because another server may run the job.
    using LookUp = std::function<void(const std::string& id, WatchedJob& job)>;

    JobWatch(std::shared_ptr<WatchedJob> job, LookUp look_up) : job_(std::move(job)), look_up_(std::move(look_up)) {}

    /// Waits for the next state. The first call returns the current state. Later calls return the state after each
    /// iteration, and finally the state of the finished job. If another server runs the job, iterations may be skipped.
    /// @returns  none if there is no new state by `until`
    std::optional<Job> next(std::chrono::steady_clock::time_point until);

    /// Makes the next call of next() ask the store. Needed because jobs can be removed without a notification.
    void look_again() { job_->mark_stale(); }

    /// Whether there will be no further states: the job has ended or no longer exists.
    bool is_over() const { return over_; }

private:
    std::shared_ptr<WatchedJob> job_;
    LookUp look_up_;
    std::optional<std::size_t> seen_;  ///< number of iterations processed so far; none before the first call of next()
    bool over_ = false;
};

/// The jobs that clients follow. Thread-safe.
class WatchedJobs {
public:
    /// Starts to follow a job, until all returned pointers to it are destroyed.
    std::shared_ptr<WatchedJob> watch(const std::string& id);

    /// Calls WatchedJob::advance() if the job is followed.
    void advance(const Job& job) const;
    void mark_stale(const std::string& id) const;
    void mark_all_stale() const;

private:
    std::shared_ptr<WatchedJob> find(const std::string& id) const;

    mutable std::mutex mutex_;  ///< guards the member below
    std::map<std::string, std::weak_ptr<WatchedJob>> jobs_;
};

}  // namespace ccdt::server

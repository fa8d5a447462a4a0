// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/job.h"
#include "server/jobs/job_limits.h"
#include "server/pool/fair_queue.h"

namespace ccdt::server {

/// The queue and the claims of a store that only one server uses. Not thread-safe.
class JobQueue {
    using Clock = std::chrono::steady_clock;

    struct Waiting {
        std::string id;
        std::size_t memory = 0;
    };

public:
    using Entry = FairQueue<Waiting>::Entry;

    explicit JobQueue(const JobLimits& limits) : max_queued_(limits.waiting), lease_(limits.lease) {}

    std::size_t queued() const { return queue_.size(); }
    std::size_t claimed() const { return claims_.size(); }

    /// Whether the queue has space for a job of this client, by the rule of JobStore::is_full.
    bool accepts_job_of(std::string_view client) const;

    void push(const Job& job) { queue_.push(job.client, job.cost.seconds, {job.id, job.cost.memory}); }

    /// Requeues the jobs whose leases have expired, then takes the next job that needs at most `memory` bytes. The
    /// caller must then call claim() or put_back(), unless the job's data is damaged.
    std::optional<Entry> take_next(std::size_t memory);
    void put_back(Entry entry) { queue_.put_back(std::move(entry)); }

    /// Claims a job that take_next() returned, and sets `job.claim`.
    void claim(Entry entry, Job& job);

    /// Returns the latest state of a claimed job; null if the job is not claimed.
    const Job* find(const std::string& id) const;

    /// Whether the claim of a job is still valid.
    bool owns(const Job& job) const;

    /// Renews the lease of a claimed job, and stores its status and progress.
    /// @param now  becomes `Job::started` at the first call with the status Running
    /// @returns    false if the claim is no longer valid
    bool renew(const Job& job, Time now);

    /// Returns a claimed job to the front of the queue.
    /// @returns  false if the claim is no longer valid
    bool requeue(const Job& job);

    /// Ends the claim of a job that has finished, and charges its client the processor time used.
    void finish(const Job& job);

    /// Removes a job from the queue and ends its claim.
    void withdraw(const std::string& id);

private:
    struct Claim {
        Entry entry;
        Job job;
        Clock::time_point until;
    };

    const std::size_t max_queued_;
    const std::chrono::milliseconds lease_;
    FairQueue<Waiting> queue_;
    std::map<std::string, Claim> claims_;
    std::uint64_t last_claim_ = 0;
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_queue.h"

#include <utility>

namespace ccdt::server {

bool JobQueue::accepts_job_of(std::string_view client) const {
    return queue_.size() < max_queued_ || (queue_.size() < 2 * max_queued_ && !queue_.has(client));
}

std::optional<JobQueue::Entry> JobQueue::take_next(std::size_t memory) {
    std::erase_if(claims_, [this, now = Clock::now()](auto& claimed) {
        const bool expired = claimed.second.until <= now;
        if (expired) queue_.put_back(std::move(claimed.second.entry));
        return expired;
    });
    return queue_.take_next_of([&](const Waiting& job) { return job.memory <= memory; });
}

void JobQueue::claim(Entry entry, Job& job) {
    job.claim = ++last_claim_;
    claims_.insert_or_assign(job.id, Claim{std::move(entry), job, Clock::now() + lease_});
}

const Job* JobQueue::find(const std::string& id) const {
    const auto found = claims_.find(id);
    return found == claims_.end() ? nullptr : &found->second.job;
}

bool JobQueue::owns(const Job& job) const {
    const Job* const claimed = find(job.id);
    return claimed != nullptr && claimed->claim == job.claim;
}

bool JobQueue::renew(const Job& job, Time now) {
    if (!owns(job)) return false;
    Claim& claim = claims_.at(job.id);
    claim.until = Clock::now() + lease_;
    if (job.status == JobStatus::Running && !claim.job.started) claim.job.started = now;
    claim.job.status = job.status;
    claim.job.progress = job.progress;
    return true;
}

bool JobQueue::requeue(const Job& job) {
    if (!owns(job)) return false;
    queue_.put_back(std::move(claims_.at(job.id).entry));
    claims_.erase(job.id);
    return true;
}

void JobQueue::finish(const Job& job) {
    const auto claim = claims_.find(job.id);
    if (claim == claims_.end()) return;
    const Entry& entry = claim->second.entry;
    if (job.used > 0) queue_.charge(entry.client, entry.generation, entry.cost, job.used);
    claims_.erase(claim);
}

void JobQueue::withdraw(const std::string& id) {
    claims_.erase(id);
    queue_.withdraw([&](const Waiting& job) { return job.id == id; });
}

}  // namespace ccdt::server

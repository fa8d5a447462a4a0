// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/watched_jobs.h"

#include <utility>

namespace ccdt::server {

void WatchedJob::advance(const Job& job) {
    const std::lock_guard lock(mutex_);
    if (is_finished(job_.status)) return;
    const bool is_first = job_.id.empty();
    const bool is_later = job.claim > job_.claim;
    const bool is_further = job.progress.fraction > (is_later ? 0 : job_.progress.fraction);
    if (!is_first && !is_later && !is_further && !is_finished(job.status)) return;
    if (!is_first && is_further && !is_finished(job.status)) steps_.push_back(job.progress);
    job_ = job;
    changed_.notify_all();
}

void WatchedJob::mark_stale() {
    const std::lock_guard lock(mutex_);
    stale_ = true;
    changed_.notify_all();
}

void WatchedJob::mark_gone() {
    const std::lock_guard lock(mutex_);
    gone_ = true;
    changed_.notify_all();
}

std::optional<Job> JobWatch::next(std::chrono::steady_clock::time_point until) {
    WatchedJob& watched = *job_;
    std::unique_lock lock(watched.mutex_);
    while (!over_) {
        if (seen_ && *seen_ < watched.steps_.size()) {
            Job job = watched.job_;
            job.status = JobStatus::Running;
            job.finished.reset();
            job.failure.reset();
            job.progress = watched.steps_[(*seen_)++];
            return job;
        }
        const bool first = !seen_;
        seen_ = watched.steps_.size();
        over_ = is_finished(watched.job_.status) || watched.gone_;
        if (first || is_finished(watched.job_.status)) return watched.job_;
        if (std::exchange(watched.stale_, false)) {
            const std::string id = watched.job_.id;  // a copy, because another thread may assign job_ meanwhile
            lock.unlock();
            look_up_(id, watched);
            lock.lock();
            continue;
        }
        const auto has_news = [&] {
            return *seen_ < watched.steps_.size() || is_finished(watched.job_.status) || watched.gone_ ||
                   watched.stale_;
        };
        if (!over_ && !watched.changed_.wait_until(lock, until, has_news)) return std::nullopt;
    }
    return std::nullopt;
}

std::shared_ptr<WatchedJob> WatchedJobs::watch(const std::string& id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [](const auto& other) { return other.second.expired(); });
    auto& known = jobs_[id];
    auto job = known.lock();
    if (!job) known = job = std::make_shared<WatchedJob>();
    return job;
}

std::shared_ptr<WatchedJob> WatchedJobs::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    return found == jobs_.end() ? nullptr : found->second.lock();
}

void WatchedJobs::advance(const Job& job) const {
    if (const auto watched = find(job.id)) watched->advance(job);
}

void WatchedJobs::mark_stale(const std::string& id) const {
    if (const auto watched = find(id)) watched->mark_stale();
}

void WatchedJobs::mark_all_stale() const {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, other] : jobs_)
        if (const auto watched = other.lock()) watched->mark_stale();
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/claimed_runs.h"

#include <algorithm>

namespace ccdt::server {
namespace {

/// Minimum time between two updates of a run's progress in the store.
constexpr std::chrono::milliseconds kProgressInterval{100};

}  // namespace

Job JobRun::job() const {
    const std::lock_guard lock(mutex_);
    return job_;
}

bool JobRun::is_gone() const {
    const std::lock_guard lock(mutex_);
    return stop_ == Stop::Gone;
}

std::optional<WorkerPool::JobId> JobRun::pool_id() const {
    const std::lock_guard lock(mutex_);
    return pool_id_;
}

void JobRun::enter_pool(const std::function<WorkerPool::JobId()>& submit) {
    const std::lock_guard lock(mutex_);
    pool_id_ = submit();
}

JobRun::Next JobRun::begin(const Result<JobStore::Renewal>& renewal, Clock::duration timeout) {
    const std::lock_guard lock(mutex_);
    if (settling_ || stop_ == Stop::Gone) return Next::Nothing;
    if (stop_ == Stop::Shutdown) return Next::Requeue;
    // The job runs even if the store failed, because no other server can claim the job before the lease expires.
    job_.status = JobStatus::Running;
    job_.started = renewal
                       ? renewal->now
                       : std::max(time_now(), job_.created);  // `created` is from the store's clock, which may be ahead
    renewed_ = Clock::now();
    deadline_ = renewed_ + timeout;
    return Next::Proceed;
}

bool JobRun::note(const Progress& progress) {
    const std::lock_guard lock(mutex_);
    if (settling_ || stop_ == Stop::Gone) return false;
    job_.progress = {progress.done(), progress.iteration, progress.variation};
    return std::exchange(progress_stored_, false);
}

JobRun::Next JobRun::finish(bool whole, bool repeat) {
    const std::lock_guard lock(mutex_);
    deadline_.reset();
    if (settling_ || stop_ == Stop::Gone) return Next::Nothing;
    if (repeat || (stop_ == Stop::Shutdown && !whole)) return Next::Requeue;
    settling_ = true;
    return Next::Proceed;
}

bool JobRun::stop(Stop why) {
    const std::lock_guard lock(mutex_);
    if (settling_ || stop_ == Stop::Gone) return false;
    stop_ = why;
    return true;
}

bool JobRun::give_up(JobStore::Owned owned) {
    if (stop(Stop::Gone)) {
        unneeded_.request_stop();
        return true;
    }
    // Another thread is storing the end of the job, which the store will refuse.
    const std::lock_guard lock(mutex_);
    if (owned == JobStore::Owned::Cancelled) stop_ = Stop::Gone;
    return false;
}

bool JobRun::start_settling() {
    const std::lock_guard lock(mutex_);
    deadline_.reset();
    return !std::exchange(settling_, true);
}

void JobRun::keep_end(End end) {
    const std::lock_guard lock(mutex_);
    end_ = std::move(end);
}

bool JobRun::has_end() const {
    const std::lock_guard lock(mutex_);
    return end_.has_value();
}

std::optional<JobRun::End> JobRun::take_end() {
    const std::lock_guard lock(mutex_);
    return std::exchange(end_, std::nullopt);
}

bool JobRun::is_overdue() const {
    const std::lock_guard lock(mutex_);
    return deadline_ && stop_ == Stop::None && *deadline_ <= Clock::now();
}

JobRun::Clock::time_point JobRun::next_due(Clock::duration interval) const {
    const std::lock_guard lock(mutex_);
    const auto renewal = next_renewal_locked(interval);
    return deadline_ && stop_ == Stop::None ? std::min(*deadline_, renewal) : renewal;
}

JobRun::Clock::time_point JobRun::next_renewal_locked(Clock::duration interval) const {
    return renewed_ + (progress_stored_ ? interval : std::min<Clock::duration>(kProgressInterval, interval));
}

std::optional<Job> JobRun::take_due(Clock::duration interval) {
    const std::lock_guard lock(mutex_);
    if (next_renewal_locked(interval) > Clock::now()) return std::nullopt;
    progress_stored_ = true;
    return job_;
}

void JobRun::renewed(bool stored) {
    const std::lock_guard lock(mutex_);
    renewed_ = Clock::now();
    if (!stored) progress_stored_ = false;
}

void JobRun::forget_stored_progress() {
    const std::lock_guard lock(mutex_);
    progress_stored_ = false;
}

void JobRun::add_latest(Job& job) const {
    const std::lock_guard lock(mutex_);
    if (is_finished(job.status) || job_.claim != job.claim) return;
    job.status = job_.status;
    job.started = job_.started;
    job.progress = job_.progress;
}

void ClaimedRuns::start() {
    {
        const std::lock_guard lock(mutex_);
        started_ = true;
    }
    wake_claimer();
}

std::vector<ClaimedRuns::Run> ClaimedRuns::drain() {
    {
        const std::lock_guard lock(mutex_);
        if (std::exchange(draining_, true)) return {};
    }
    return all();
}

bool ClaimedRuns::is_draining() const {
    const std::lock_guard lock(mutex_);
    return draining_;
}

bool ClaimedRuns::may_claim() const {
    const std::lock_guard lock(mutex_);
    // Ends that are not stored yet count as jobs in the pool, because they take memory.
    const auto ends = std::ranges::count_if(runs_, [](const auto& run) { return run.second->has_end(); });
    return started_ && !draining_ && in_pool_ + static_cast<std::size_t>(ends) < at_once_;
}

bool ClaimedRuns::add(const Run& run, bool for_pool) {
    const Job job = run->job();
    const std::lock_guard lock(mutex_);
    runs_.insert_or_assign(job.id, run);
    if (job.starts > 1) ++counts_.repeated;
    if (draining_ || !for_pool) return false;
    ++in_pool_;
    return true;
}

void ClaimedRuns::leave_pool() {
    const std::lock_guard lock(mutex_);
    --in_pool_;
    has_work_ = true;
    wake_.notify_all();
}

void ClaimedRuns::wait_until_pool_is_left() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return in_pool_ == 0; });
}

void ClaimedRuns::erase(const Run& run) {
    const std::lock_guard lock(mutex_);
    std::erase_if(runs_, [&](const auto& other) { return other.second == run; });
}

ClaimedRuns::Run ClaimedRuns::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = runs_.find(id);
    return found == runs_.end() ? nullptr : found->second;
}

std::vector<ClaimedRuns::Run> ClaimedRuns::all() const {
    std::vector<Run> runs;
    const std::lock_guard lock(mutex_);
    for (const auto& [id, run] : runs_) runs.push_back(run);
    return runs;
}

void ClaimedRuns::count_lost() {
    const std::lock_guard lock(mutex_);
    ++counts_.lost;
}

ClaimedRuns::Counts ClaimedRuns::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

void ClaimedRuns::wake_claimer() {
    const std::lock_guard lock(mutex_);
    has_work_ = true;
    wake_.notify_all();
}

void ClaimedRuns::wait_for_work(const std::stop_token& closing, Clock::duration pause) {
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, closing, pause, [this] { return has_work_; });
    has_work_ = false;
}

void ClaimedRuns::wake_timekeeper() {
    const std::lock_guard lock(mutex_);
    changed_ = true;
    wake_.notify_all();
}

void ClaimedRuns::wait_for_change(const std::stop_token& closing, Clock::time_point until) {
    std::unique_lock lock(mutex_);
    wake_.wait_until(lock, closing, until, [this] { return changed_; });
    changed_ = false;
}

}  // namespace ccdt::server

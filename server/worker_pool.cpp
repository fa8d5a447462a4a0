#include "server/worker_pool.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace ccdt::server {
namespace {

/// Weight of the newest job in the running average: the last ten or so decide.
constexpr double kNewestWeight = 0.2;

constexpr double kLongestBacklog = 3600;

double seconds_since(WorkerPool::Clock::time_point start) {
    return std::chrono::duration<double>(WorkerPool::Clock::now() - start).count();
}

}  // namespace

WorkerPool::WorkerPool(std::size_t workers, std::size_t capacity) : worker_count_(workers), capacity_(capacity) {
    assert(workers >= 1);
    workers_.reserve(workers);
    for (std::size_t i = 0; i < workers; ++i)
        workers_.emplace_back([this](const std::stop_token& closing) { work(closing); });
}

WorkerPool::~WorkerPool() {
    for (auto& worker : workers_) worker.request_stop();
    const std::lock_guard lock(mutex_);
    for (auto& [id, job] : running_) job.stop.request_stop();
}

std::optional<WorkerPool::JobId> WorkerPool::submit(const std::string& client, Job job) {
    const std::lock_guard lock(mutex_);
    if (is_full_locked(client)) return std::nullopt;
    waiting_.push_back({++last_id_, client, next_turn_locked(client), Clock::now(), std::move(job)});
    job_waits_.notify_one();
    return last_id_;
}

WorkerPool::Cancelled WorkerPool::cancel(JobId id) {
    Waiting dropped;  // destroyed after the lock is released: its captures may be large
    const std::lock_guard lock(mutex_);
    if (const auto job = running_.find(id); job != running_.end()) {
        job->second.stop.request_stop();
        if (!job->second.cancelled) job->second.cancelled = Clock::now();
        return Cancelled::Running;
    }
    const auto job = std::ranges::find(waiting_, id, &Waiting::id);
    if (job == waiting_.end()) return Cancelled::Unknown;
    dropped = std::move(*job);
    waiting_.erase(job);
    if (waiting_.empty() && running_.empty()) idle_.notify_all();
    return Cancelled::Queued;
}

bool WorkerPool::is_full(std::string_view client) const {
    const std::lock_guard lock(mutex_);
    return is_full_locked(client);
}

void WorkerPool::drain() {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return waiting_.empty() && running_.empty(); });
}

std::chrono::seconds WorkerPool::backlog() const {
    const std::lock_guard lock(mutex_);
    // One job more than wait: the first of them begins only when a running one ends.
    const double jobs = static_cast<double>(waiting_.size() + 1);
    const double seconds = jobs * expected_seconds_locked() / static_cast<double>(worker_count_);
    return std::chrono::seconds(static_cast<std::int64_t>(std::ceil(std::clamp(seconds, 1.0, kLongestBacklog))));
}

WorkerPool::Load WorkerPool::load() const {
    const std::lock_guard lock(mutex_);
    Load load{.workers = worker_count_, .busy = running_.size(), .waiting = waiting_.size(), .capacity = capacity_};
    if (!waiting_.empty()) {
        load.oldest_seconds = seconds_since(waiting_.front().came);
        load.backlog_seconds =
            static_cast<double>(waiting_.size()) * expected_seconds_locked() / static_cast<double>(worker_count_);
    }
    for (const auto& [id, job] : running_) {
        if (job.cancelled) load.overdue_seconds = std::max(load.overdue_seconds, seconds_since(*job.cancelled));
    }
    return load;
}

void WorkerPool::work(const std::stop_token& closing) {
    std::unique_lock lock(mutex_);
    while (job_waits_.wait(lock, closing, [this] { return !waiting_.empty(); }) && !closing.stop_requested()) {
        Waiting next = take_next_locked();
        const JobId id = next.id;
        const Running& running = running_.emplace(id, Running{{}, Clock::now()}).first->second;
        const auto started = running.started;
        const std::stop_token stop = running.stop.get_token();

        lock.unlock();
        run(next.job, stop);
        next = {};  // what it holds may be large, and is freed without the lock
        lock.lock();

        const double seconds = seconds_since(started);
        average_seconds_ += (average_seconds_ == 0 ? 1 : kNewestWeight) * (seconds - average_seconds_);
        running_.erase(id);
        if (waiting_.empty() && running_.empty()) idle_.notify_all();
    }
}

void WorkerPool::run(const Job& job, const std::stop_token& stop) {
    try {
        job(stop);
    } catch (...) {
        // A worker outlives any job; whoever waits for the result has the job report its own failure.
    }
}

bool WorkerPool::is_full_locked(std::string_view client) const {
    const std::size_t idle_workers = worker_count_ - running_.size();
    if (waiting_.size() < capacity_ + idle_workers) return false;
    return waiting_.size() >= 2 * capacity_ + idle_workers ||
           std::ranges::find(waiting_, client, &Waiting::client) != waiting_.end();
}

/// The one after the client's last waiting job, and never one that is past.
std::uint64_t WorkerPool::next_turn_locked(std::string_view client) const {
    std::uint64_t turn = turn_;
    for (const Waiting& job : waiting_) {
        if (job.client == client) turn = std::max(turn, job.turn + 1);
    }
    return turn;
}

/// Of those whose turn is first, the one that came first.
WorkerPool::Waiting WorkerPool::take_next_locked() {
    const auto next = std::ranges::min_element(waiting_, {}, &Waiting::turn);
    Waiting taken = std::move(*next);
    waiting_.erase(next);
    turn_ = taken.turn;
    return taken;
}

double WorkerPool::expected_seconds_locked() const {
    double expected = average_seconds_;
    // A job that already took longer than the average says more than the average.
    for (const auto& [id, job] : running_) expected = std::max(expected, seconds_since(job.started));
    return expected;
}

}  // namespace ccdt::server

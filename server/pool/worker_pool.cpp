// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/worker_pool.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include "server/pool/thread_share.h"

namespace ccdt::server {
namespace {

/// Weight of the newest job in the running average `pace_`, which covers about ten jobs.
constexpr double kNewestWeight = 0.2;

constexpr double kLongestBacklog = 3600;

/// Bounds of actual / estimated duration. Beyond them, the job has failed early or was delayed.
constexpr double kMinPace = 0.1, kMaxPace = 10;

double seconds_since(WorkerPool::Clock::time_point start) {
    return std::chrono::duration<double>(WorkerPool::Clock::now() - start).count();
}

/// Lowers the priority of the calling thread below that of threads for connections and short jobs.
void yield_to_other_threads() {
    const auto thread = static_cast<id_t>(gettid());
    setpriority(PRIO_PROCESS, thread, std::max(getpriority(PRIO_PROCESS, thread), WorkerPool::kNiceOfLong));
}

}  // namespace

WorkerPool::WorkerPool(std::size_t workers, std::size_t capacity, std::size_t memory)
    : worker_count_(workers), capacity_(capacity), memory_(memory) {
    assert(workers >= 1);
    memory_.on_release([this] {
        const std::lock_guard lock(mutex_);  // otherwise a worker about to wait would miss the notification
        wake_all_locked();
    });
    const std::size_t most = max_computations(workers);
    threads_.reserve(most + 1);
    for (std::size_t i = 0; i < most; ++i) {
        const Lane lane = i < workers ? Lane::Any : Lane::Short;
        threads_.emplace_back([this, lane](const std::stop_token& closing) { work(lane, closing); });
    }
    threads_.emplace_back([this](const std::stop_token& closing) { watch_short_lane(closing); });
}

WorkerPool::~WorkerPool() {
    for (auto& thread : threads_) thread.request_stop();
    const std::lock_guard lock(mutex_);
    for (auto& [id, job] : running_) job.stop.request_stop();
}

std::optional<WorkerPool::JobId> WorkerPool::submit(const std::string& client, Job job, const api::Cost& cost,
                                                    Displace displace) {
    const std::lock_guard lock(mutex_);
    if (!accepts_locked(client, cost.seconds <= kShort)) return std::nullopt;
    return push_locked(client, std::move(job), cost, std::move(displace));
}

WorkerPool::JobId WorkerPool::submit_always(const std::string& client, Job job, const api::Cost& cost) {
    const std::lock_guard lock(mutex_);
    return push_locked(client, std::move(job), cost, {});
}

WorkerPool::JobId WorkerPool::push_locked(const std::string& client, Job job, const api::Cost& cost,
                                          Displace displace) {
    assert(cost.memory <= memory_.total());
    Queue& queue = queue_of(cost.seconds);
    queue.push(client, cost.seconds,
               {++last_id_, client, queue.generation(), cost, Clock::now(), std::move(job), std::move(displace)});
    job_waits_.notify_all();  // notify_one might wake a thread of the wrong lane
    short_job_waits_.notify_one();
    return last_id_;
}

void WorkerPool::wake_all_locked() {
    job_waits_.notify_all();
    short_job_waits_.notify_all();
}

WorkerPool::Cancelled WorkerPool::cancel(JobId id) {
    std::optional<Waiting> dropped;  // declared before the lock, so that its large captures are freed after unlocking
    const std::lock_guard lock(mutex_);
    if (const auto job = running_.find(id); job != running_.end()) {
        job->second.stop.request_stop();
        if (!job->second.cancelled) job->second.cancelled = Clock::now();
        return Cancelled::Running;
    }
    const auto is_meant = [id](const Waiting& job) { return job.id == id; };
    dropped = long_.withdraw(is_meant);
    if (!dropped) dropped = short_.withdraw(is_meant);
    if (!dropped) return Cancelled::Unknown;
    if (is_idle_locked()) idle_.notify_all();
    wake_all_locked();  // other jobs may have waited behind it for memory
    return Cancelled::Queued;
}

bool WorkerPool::is_full(std::string_view client, bool may_be_short) const {
    const std::lock_guard lock(mutex_);
    return !accepts_locked(client, false) && !(may_be_short && accepts_locked(client, true));
}

void WorkerPool::drain() {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return is_idle_locked(); });
}

std::chrono::seconds WorkerPool::backlog() const {
    const std::lock_guard lock(mutex_);
    const double seconds = std::clamp(waiting_seconds_locked(), 1.0, kLongestBacklog);
    return std::chrono::seconds(static_cast<std::int64_t>(std::ceil(seconds)));
}

WorkerPool::Load WorkerPool::load() const {
    const std::lock_guard lock(mutex_);
    Load load{.workers = worker_count_, .busy = running_.size(), .waiting = waiting_locked(), .capacity = capacity_};
    for (const Queue* queue : {&long_, &short_}) {
        if (!queue->empty())
            load.oldest_seconds = std::max(load.oldest_seconds, seconds_since(queue->begin()->item.came));
    }
    if (load.waiting > 0) load.backlog_seconds = waiting_seconds_locked();
    for (const auto& [id, job] : running_) {
        if (job.cancelled) load.overdue_seconds = std::max(load.overdue_seconds, seconds_since(*job.cancelled));
    }
    return load;
}

void WorkerPool::work(Lane lane, const std::stop_token& closing) {
    if (lane == Lane::Any) yield_to_other_threads();
    std::unique_lock lock(mutex_);
    while (true) {
        std::optional<Waiting> job;
        std::optional<MemoryBudget::Lease> memory;
        auto& waits = lane == Lane::Any ? job_waits_ : short_job_waits_;
        const bool found = waits.wait(lock, closing, [&] {
            if (!job) job = take_job_locked(lane, memory);
            return job.has_value();
        });
        if (!found || closing.stop_requested()) {
            lock.unlock();  // releasing the memory locks the mutex
            return;
        }
        const JobId id = job->id;
        Turn turn{begin_locked(*job, lane)};

        lock.unlock();
        run(job->job, turn);
        job.reset();  // frees large captures without the lock
        memory.reset();
        lock.lock();
        finish_locked(id, turn.used);
    }
}

void WorkerPool::run(const Job& job, Turn& turn) {
    try {
        job(turn);
    } catch (...) {
        // A failed job must not end the worker. Jobs report their own failures.
    }
}

/// Makes each job in the lane of short jobs leave it when its time is over.
void WorkerPool::watch_short_lane(const std::stop_token& closing) {
    std::unique_lock lock(mutex_);
    while (!closing.stop_requested()) {
        if (!short_lane_used_.wait(lock, closing, [this] { return in_short_lane_.has_value(); })) return;
        const JobId job = *in_short_lane_;
        watched_ = true;
        short_lane_used_.wait_until(lock, closing, running_.at(job).started + kOverrun, [] { return false; });
        watched_ = false;
        if (in_short_lane_ == job && !closing.stop_requested()) leave_short_lane_locked();
    }
}

/// Counts the job in the lane of short jobs as an overrun, so that another thread may run the next short job. If there
/// are more overruns than workers, displaces the earliest one that can be displaced, because the latest ones may be
/// short and only delayed by a busy machine.
void WorkerPool::leave_short_lane_locked() {
    running_.at(*in_short_lane_).lane = Lane::Overrun;
    in_short_lane_.reset();
    short_job_waits_.notify_one();
    if (count_locked(Lane::Overrun) <= worker_count_) return;
    for (auto& [id, job] : running_) {
        if (job.lane != Lane::Overrun || !job.displace || !job.displace()) continue;
        job.lane = Lane::Displaced;
        job.stop.request_stop();
        return;
    }
}

std::size_t WorkerPool::count_locked(Lane lane) const {
    return static_cast<std::size_t>(
        std::ranges::count(running_, lane, [](const auto& job) { return job.second.lane; }));
}

/// Whether a queue accepts another job of this client. The limit grows by the number of idle threads, because these
/// take jobs at once.
bool WorkerPool::accepts_locked(std::string_view client, bool is_short) const {
    const std::size_t free = worker_count_ - count_locked(Lane::Any) + (is_short && !in_short_lane_ ? 1 : 0);
    const Queue& queue = is_short ? short_ : long_;
    if (queue.size() < capacity_ + free) return true;
    return queue.size() < 2 * capacity_ + free && !queue.has(client);
}

/// Takes the next job that a thread may run, and reserves its memory. Long jobs come first, because short jobs have a
/// separate slot. Considers only the next job of each queue, even if later jobs need less memory.
std::optional<WorkerPool::Waiting> WorkerPool::take_job_locked(Lane lane, std::optional<MemoryBudget::Lease>& memory) {
    if (lane == Lane::Short && in_short_lane_) return std::nullopt;
    for (Queue* queue : {&long_, &short_}) {
        if (queue->empty() || (queue == &long_ && lane == Lane::Short)) continue;
        memory = memory_.reserve(queue->next().item.cost.memory);
        if (memory) return queue->take_next();
    }
    return std::nullopt;
}

std::stop_token WorkerPool::begin_locked(Waiting& job, Lane lane) {
    const auto& running = running_
                              .emplace(job.id, Running{{},
                                                       std::move(job.client),
                                                       job.generation,
                                                       std::move(job.displace),
                                                       lane,
                                                       job.cost.seconds,
                                                       Clock::now()})
                              .first->second;
    if (lane == Lane::Short) {
        in_short_lane_ = job.id;
        if (!watched_) short_lane_used_.notify_one();
    }
    callback_(running_.size());
    return running.stop.get_token();
}

/// @param used  processor time of the job in seconds; 0: unknown
void WorkerPool::finish_locked(JobId id, double used) {
    const auto job = running_.find(id);
    const double expected = job->second.expected;
    queue_of(expected).charge(job->second.client, job->second.generation, expected,
                              used > 0 ? used : seconds_since(job->second.started));
    if (in_short_lane_ == id) in_short_lane_.reset();
    // Jobs that could use additional threads do not count, because they are faster than estimated.
    const bool was_lent = threads_for_each(worker_count_, running_.size(), worker_count_) > 1;
    if (!job->second.cancelled && job->second.expected > 0 && !was_lent) {
        const double taken = seconds_since(job->second.started) / job->second.expected;
        pace_ += kNewestWeight * (std::clamp(taken, kMinPace, kMaxPace) - pace_);
    }
    running_.erase(job);
    callback_(running_.size());
    if (is_idle_locked()) idle_.notify_all();
}

/// Estimates the time until a job submitted now would start, in seconds.
double WorkerPool::waiting_seconds_locked() const {
    double expected = 0;
    for (const Queue* queue : {&long_, &short_}) {
        for (const auto& waiting : *queue) expected += waiting.cost;
    }
    double pace = pace_;
    for (const auto& [id, job] : running_) {
        const double gone = seconds_since(job.started);
        // A running job that is already slower than the average is more recent evidence than the finished jobs.
        if (job.expected > 0) pace = std::max(pace, std::min(gone / job.expected, kMaxPace));
        expected += std::max(job.expected - gone / pace, 0.0);
    }
    return expected * pace / static_cast<double>(worker_count_);
}

}  // namespace ccdt::server

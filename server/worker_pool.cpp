#include "server/worker_pool.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

namespace ccdt::server {
namespace {

/// Weight of the newest job in the running average: the last ten or so decide.
constexpr double kNewestWeight = 0.2;

constexpr double kLongestBacklog = 3600;

/// An expectation may be wrong by so much; more says that the job failed early, or that its worker was held up.
constexpr double kLeastPace = 0.1, kMostPace = 10;

double seconds_since(WorkerPool::Clock::time_point start) {
    return std::chrono::duration<double>(WorkerPool::Clock::now() - start).count();
}

/// Has the calling thread give way to those that read requests, answer at once or do short jobs.
void yield_to_other_threads() {
    constexpr int kNice = 10;
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

WorkerPool::WorkerPool(std::size_t workers, std::size_t capacity, std::size_t memory)
    : worker_count_(workers), capacity_(capacity), memory_(memory) {
    assert(workers >= 1);
    memory_.on_return([this] {
        { const std::lock_guard lock(mutex_); }  // or a worker that has just looked would miss it
        job_waits_.notify_all();
    });
    workers_.reserve(workers + 1);
    for (std::size_t i = 0; i <= workers; ++i) {
        const Lane lane = i < workers ? Lane::Any : Lane::Short;
        workers_.emplace_back([this, lane](const std::stop_token& closing) { work(lane, closing); });
    }
}

WorkerPool::~WorkerPool() {
    for (auto& worker : workers_) worker.request_stop();
    const std::lock_guard lock(mutex_);
    for (auto& [id, job] : running_) job.stop.request_stop();
}

std::optional<WorkerPool::JobId> WorkerPool::submit(const std::string& client, Job job, const api::Cost& cost) {
    assert(cost.memory <= memory_.total());
    const std::lock_guard lock(mutex_);
    if (!has_room_locked(client, cost.seconds <= kShort)) return std::nullopt;
    const double turn = take_turn_locked(client, cost.seconds);
    waiting_.push_back({++last_id_, client, cost, turn, Clock::now(), std::move(job)});
    job_waits_.notify_all();  // not each of them may take it
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
    if (const auto had = had_.find(dropped.client); had != had_.end()) had->second -= dropped.cost.seconds;
    if (waiting_.empty() && running_.empty()) idle_.notify_all();
    job_waits_.notify_all();  // it may have kept others waiting for memory
    return Cancelled::Queued;
}

bool WorkerPool::is_full(std::string_view client, bool may_be_short) const {
    const std::lock_guard lock(mutex_);
    return !has_room_locked(client, false) && !(may_be_short && has_room_locked(client, true));
}

void WorkerPool::drain() {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return waiting_.empty() && running_.empty(); });
}

std::chrono::seconds WorkerPool::backlog() const {
    const std::lock_guard lock(mutex_);
    const double seconds = std::clamp(waiting_seconds_locked(), 1.0, kLongestBacklog);
    return std::chrono::seconds(static_cast<std::int64_t>(std::ceil(seconds)));
}

WorkerPool::Load WorkerPool::load() const {
    const std::lock_guard lock(mutex_);
    Load load{.workers = worker_count_, .busy = running_.size(), .waiting = waiting_.size(), .capacity = capacity_};
    if (!waiting_.empty()) {
        load.oldest_seconds = seconds_since(waiting_.front().came);
        load.backlog_seconds = waiting_seconds_locked();
    }
    for (const auto& [id, job] : running_) {
        if (job.cancelled) load.overdue_seconds = std::max(load.overdue_seconds, seconds_since(*job.cancelled));
    }
    return load;
}

void WorkerPool::work(Lane lane, const std::stop_token& closing) {
    if (lane == Lane::Any) yield_to_other_threads();
    std::unique_lock lock(mutex_);
    while (true) {
        auto next = waiting_.end();
        std::optional<MemoryBudget::Lease> memory;
        // Of what is to be done next only the first is looked at: if it has to wait for memory, so do the others.
        const bool found = job_waits_.wait(lock, closing, [&] {
            next = find_next_locked(lane);
            if (next != waiting_.end()) memory = memory_.take(next->cost.memory);
            return memory.has_value();
        });
        if (!found || closing.stop_requested()) {
            lock.unlock();  // giving the memory back takes it
            return;
        }
        Waiting job = start_locked(next);
        const JobId id = job.id;
        const std::stop_token stop = running_.at(id).stop.get_token();

        lock.unlock();
        run(job.job, stop);
        job = {};  // what it holds may be large, and is freed without the lock
        memory.reset();
        lock.lock();
        finish_locked(id);
    }
}

void WorkerPool::run(const Job& job, const std::stop_token& stop) {
    try {
        job(stop);
    } catch (...) {
        // A worker outlives any job; whoever waits for the result has the job report its own failure.
    }
}

/// Jobs that a free thread will take at once do not count as waiting.
bool WorkerPool::has_room_locked(std::string_view client, bool is_short) const {
    const auto is_alike = [is_short](const Waiting& job) { return (job.cost.seconds <= kShort) == is_short; };
    const auto waiting = static_cast<std::size_t>(std::ranges::count_if(waiting_, is_alike));
    const std::size_t threads = worker_count_ + (is_short ? 1 : 0);
    const std::size_t free = threads - std::min(running_.size(), threads);
    if (waiting < capacity_ + free) return true;
    if (waiting >= 2 * capacity_ + free) return false;
    return std::ranges::none_of(waiting_, [&](const Waiting& job) { return is_alike(job) && job.client == client; });
}

/// After what the client has had, and never a turn that is past.
double WorkerPool::take_turn_locked(const std::string& client, double seconds) {
    double& had = had_.try_emplace(client, turn_).first->second;
    const double turn = std::max(turn_, had);
    had = turn + seconds;
    return turn;
}

/// Of those whose turn is first, the one that came first. The thread for short jobs leaves them to the others as long
/// as one of those is free.
WorkerPool::Queue::iterator WorkerPool::find_next_locked(Lane lane) {
    if (lane == Lane::Short && running_.size() < worker_count_) return waiting_.end();
    auto next = waiting_.end();
    for (auto job = waiting_.begin(); job != waiting_.end(); ++job) {
        if (lane == Lane::Short && job->cost.seconds > kShort) continue;
        if (next == waiting_.end() || job->turn < next->turn) next = job;
    }
    return next;
}

WorkerPool::Waiting WorkerPool::start_locked(Queue::iterator next) {
    Waiting job = std::move(*next);
    waiting_.erase(next);
    turn_ = std::max(turn_, job.turn);
    std::erase_if(had_, [this](const auto& client) { return client.second <= turn_; });
    running_.emplace(job.id, Running{{}, job.cost.seconds, Clock::now()});
    job_waits_.notify_all();  // with all workers busy the thread for short jobs may go on
    return job;
}

void WorkerPool::finish_locked(JobId id) {
    const auto job = running_.find(id);
    if (!job->second.cancelled && job->second.expected > 0) {
        const double taken = seconds_since(job->second.started) / job->second.expected;
        pace_ += kNewestWeight * (std::clamp(taken, kLeastPace, kMostPace) - pace_);
    }
    running_.erase(job);
    if (!waiting_.empty() || !running_.empty()) return;
    // Nobody has to make up for anything.
    turn_ = 0;
    had_.clear();
    idle_.notify_all();
}

/// Until a job that came now would begin.
double WorkerPool::waiting_seconds_locked() const {
    double expected = 0;
    for (const Waiting& job : waiting_) expected += job.cost.seconds;
    double pace = pace_;
    for (const auto& [id, job] : running_) {
        const double gone = seconds_since(job.started);
        // A job that already took longer than at this pace says more than those before it.
        if (job.expected > 0) pace = std::max(pace, std::min(gone / job.expected, kMostPace));
        expected += std::max(job.expected - gone / pace, 0.0);
    }
    return expected * pace / static_cast<double>(worker_count_);
}

}  // namespace ccdt::server

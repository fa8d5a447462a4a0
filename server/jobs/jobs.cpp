#include "server/jobs/jobs.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <system_error>
#include <utility>

#include "server/work/answer_headers.h"
#include "server/work/form.h"

namespace ccdt::server {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

/// Starts after which a job that the server did not survive is not begun again. Computing cannot end the server, so
/// that this is for faults that nobody has thought of.
constexpr int kMostStarts = 10;

/// Jobs that are forgotten in one go, lest others wait for long.
constexpr std::size_t kForgottenAtOnce = 100;

/// Time after which the clock is looked at even so: it may have been set.
constexpr std::chrono::seconds kLongestSleep{60};

/// Least pause between two looks for jobs to forget; those that have expired are not found even before.
constexpr Time::duration kShortestSleep{100};

/// 128 bits that nobody can guess: whoever knows them may read the result.
std::string new_id() {
    std::array<unsigned char, 16> bytes{};
    if (getentropy(bytes.data(), bytes.size()) != 0)
        throw std::system_error(errno, std::generic_category(), "no random numbers");
    std::string id;
    for (const unsigned byte : bytes) {
        id += "0123456789abcdef"[byte / 16];
        id += "0123456789abcdef"[byte % 16];
    }
    return id;
}

/// Makes a problem of a failure of the store; that what is the client's is damaged, the client is told.
tl::unexpected<Problem> store_problem(const Error& error) {
    auto failed = problem(error.code == ErrorCode::LimitExceeded ? 507 : 500, error.message);
    if (error.code == ErrorCode::Unusable) failed.value().error.message = error.message;
    return failed;
}

tl::unexpected<Problem> no_such_job() {
    return problem(404, "there is no such job: it never was, or it has expired");
}

Problem too_late(std::chrono::milliseconds timeout) {
    return {504,
            {ErrorCode::Stopped,
             "the computation took longer than the timeout of " + std::to_string(timeout.count()) + " ms (job-timeout)",
             {}}};
}

}  // namespace

Jobs::Jobs(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger)
    : limits_(limits),
      store_(store),
      survives_(survives),
      pool_(pool),
      compute_(std::move(compute)),
      logger_(std::move(logger)),
      at_once_(std::max<std::size_t>(2, pool.load().workers) - 1),
      timekeeper_([this](const std::stop_token& closing) { keep_time(closing); }) {}

Jobs::~Jobs() {
    drain();
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return handed_ == 0; });
}

Result<void> Jobs::start() {
    auto jobs = store_.unfinished();
    if (!jobs) return tl::unexpected(std::move(jobs.error()));
    for (Job& job : *jobs) take_up(std::move(job));
    const std::lock_guard lock(mutex_);
    started_ = true;
    feed_locked();
    return {};
}

/// Takes up a job of a server that has ended.
void Jobs::take_up(Job job) {
    std::optional<Problem> failure;
    if (job.starts >= kMostStarts)
        failure = Problem{500, {ErrorCode::Internal, "the server ended each time that it ran this job", {}}};
    if (job.cost.memory > pool_.memory().total())
        failure = Problem{413, {ErrorCode::LimitExceeded, "this server has too little memory for this job", {}}};
    job.status = JobStatus::Queued;
    job.started.reset();
    job.progress = {};
    LivePointer live;
    {
        const std::lock_guard lock(mutex_);
        const std::string id = job.id;
        if (live_.contains(id)) return;  // it was accepted by this one, before the start
        admit_locked(std::move(job));
        live = live_.at(id);
    }
    if (failure) fail(live, *std::move(failure));
}

bool Jobs::is_full(std::string_view client) const {
    const std::lock_guard lock(mutex_);
    return !has_room_locked(client);
}

/// Whether a client's job is let in: as in the pool, one that has nothing there is where others have filled the queue.
bool Jobs::has_room_locked(std::string_view client) const {
    const std::size_t waiting = queue_.size() + arriving_;
    return waiting < limits_.waiting || (waiting < 2 * limits_.waiting && !queue_.has(client));
}

HttpResult<Job> Jobs::accept(Job job, const ComputeRequest& request) {
    {
        const std::lock_guard lock(mutex_);
        if (draining_) return busy(503, "the server is shutting down", pool_.backlog());
        if (!has_room_locked(job.client)) return busy(429, "too many jobs are waiting (job-queue)", pool_.backlog());
        ++arriving_;
    }
    job.id = new_id();
    job.created = time_now();
    const auto stored = store_new(job, request);
    LivePointer live;
    {
        const std::lock_guard lock(mutex_);
        --arriving_;
        if (!stored) return tl::unexpected(stored.error());
        admit_locked(job);
        if (draining_ && !survives_) live = live_.at(job.id);
        feed_locked();
    }
    if (live) fail(live, {503, {ErrorCode::Stopped, "the server shut down", {}}});
    return job;
}

HttpResult<void> Jobs::store_new(const Job& job, const ComputeRequest& request) {
    const std::size_t bytes = JobStore::bytes_of_job(request.body.size() + request.query.size());
    if (bytes > limits_.bytes)
        return problem(413, "the request is larger than what jobs may take, " + std::to_string(limits_.bytes) +
                                " bytes (job-bytes)");
    const std::lock_guard lock(room_);
    if (!make_room(bytes)) return busy(429, "jobs that wait take all the room (job-bytes)", pool_.backlog());
    if (auto added = store_.add(job, request); !added) return store_problem(added.error());
    return {};
}

/// Drops the oldest results, and then, once there are none, what is left of the jobs that finished first.
bool Jobs::make_room(std::size_t bytes) {
    const auto is_enough = [&] { return store_.bytes() + bytes <= limits_.bytes; };
    const auto drop = [&] {
        if (store_.drop_oldest_result().value_or(false)) return true;
        return store_.remove_finished(Time::max(), 1).value_or(0) > 0;
    };
    while (!is_enough() && drop()) {
    }
    return is_enough();
}

void Jobs::admit_locked(Job job) {
    const auto live = std::make_shared<Live>();
    live->job = std::move(job);
    live_.emplace(live->job.id, live);
    queue_.push(live->job.client, live->job.cost.seconds, live);
}

/// Hands jobs to the pool while they may have more of its workers.
void Jobs::feed_locked() {
    while (started_ && !draining_ && handed_ < at_once_ && !queue_.empty()) {
        const LivePointer live = queue_.take_next();
        ++handed_;
        live->handed = pool_.submit_always(
            live->job.client, [this, live](const std::stop_token& stop) { run(live, stop); }, live->job.cost);
    }
}

/// Makes room for the next job once the pool has done one.
void Jobs::hand_next_locked() {
    --handed_;
    feed_locked();
    idle_.notify_all();
}

void Jobs::run(const LivePointer& live, const std::stop_token& stop) {
    try {
        if (const auto job = begin(live)) finish_run(live, compute(*job, live, stop));
    } catch (const std::exception& exception) {
        fail(live, problem(500, exception.what()).value());
    }
    const std::lock_guard lock(mutex_);
    hand_next_locked();
}

/// @returns  none if the job is not to be run any more
std::optional<Job> Jobs::begin(const LivePointer& live) {
    Job job;
    {
        const std::lock_guard lock(mutex_);
        if (live->settling || draining_) return std::nullopt;
        live->job.status = JobStatus::Running;
        live->job.started = time_now();
        ++live->job.starts;
        live->deadline = Clock::now() + limits_.timeout;
        news_ = true;
        wake_timekeeper_.notify_all();
        job = live->job;
    }
    // If this fails the job runs all the same; it only starts once more than is known.
    (void)store_.save(job);
    return job;
}

Jobs::Run Jobs::compute(const Job& job, const LivePointer& live, const std::stop_token& stop) {
    Run run{failure(ErrorCode::Internal, ""), {}};
    run.stages.queue = Milliseconds(*job.started - job.created).count();
    try {
        const auto request = load_request(job.id);
        if (!request) {
            run.answer = tl::unexpected(request.error());
            return run;
        }
        const Control control{stop, [&](const Progress& progress) { note(live, progress); }};
        run.answer = compute_(*request, {}, control, run.stages.work);
    } catch (const std::exception& exception) {
        run.answer = failure(ErrorCode::Internal, exception.what());
    }
    return run;
}

Result<ComputeRequest> Jobs::load_request(const std::string& id) const {
    auto stored = store_.request(id);
    if (!stored) return failure(ErrorCode::Internal, std::move(stored.error().message));
    if (!*stored) return failure(ErrorCode::Internal, "the request is lost");
    ComputeRequest request = **std::move(stored);
    // Earlier versions stored forms as they came.
    const auto apart =
        find_fields(request).and_then([&](const std::vector<FormPart>& fields) { return take_apart(request, fields); });
    if (!apart) return tl::unexpected(apart.error());
    return request;
}

void Jobs::note(const LivePointer& live, const Progress& progress) {
    const std::lock_guard lock(mutex_);
    if (live->settling) return;
    live->job.progress = {progress.done(), progress.iteration, progress.variation};
    live->steps.push_back(live->job.progress);
    live->changed.notify_all();
}

void Jobs::finish_run(const LivePointer& live, Run run) {
    Job job;
    Stop stop{};
    {
        const std::lock_guard lock(mutex_);
        if (live->settling) return;  // cancelled meanwhile
        live->settling = true;
        live->deadline.reset();
        job = live->job;
        stop = live->stop;
    }
    auto& answer = run.answer;
    const bool whole = answer ? !answer->partial : answer.error().code != ErrorCode::Stopped;
    if (stop == Stop::Shutdown && !whole) {
        job.status = JobStatus::Queued;
        job.starts = 0;
        job.started.reset();
        job.progress = {};
        (void)store_.save(job);  // if this fails it runs again for having been running
        const std::lock_guard lock(mutex_);
        live->job = std::move(job);
        live->settling = false;
        return;
    }
    JobEnd end{{}, run.stages, {}, {}};
    if (!answer) {
        const Error& error = answer.error();
        job.status = JobStatus::Failed;
        job.failure = error.code == ErrorCode::Stopped ? too_late(limits_.timeout) : problem(error).value();
        end.cause = job.failure->cause;
        settle(live, std::move(job), {}, std::move(end));
        return;
    }
    job.status = JobStatus::Succeeded;
    job.media_type = std::move(answer->media_type);
    job.partial = answer->partial;
    job.headers = answer_headers(*answer);
    end.computed = Computed{answer->sites, answer->pixels};
    settle(live, std::move(job), std::move(answer->body), std::move(end));
}

/// Stores how a job ends, which its `settling` has left to the caller, and tells those who watch it and the log.
void Jobs::settle(const LivePointer& live, Job job, std::string result, JobEnd end) {
    job.finished = time_now();
    if (job.status == JobStatus::Succeeded) job.progress.fraction = 1;
    job.result_bytes = result.size();
    const auto stored = store_end(job, result);
    if (!stored && end.cause.empty()) end.cause = stored.error().message;
    {
        const std::lock_guard lock(mutex_);
        live->job = job;
        if (stored) live_.erase(job.id);
        live->changed.notify_all();
        news_ = true;
        wake_timekeeper_.notify_all();
    }
    end.job = std::move(job);
    logger_(end);
}

/// Stores how a job ends; a result that cannot be stored makes a failure, which takes no room.
Result<void> Jobs::store_end(Job& job, std::string_view result) {
    Result<void> stored;
    {
        const std::lock_guard lock(room_);
        if (!result.empty() && !make_room(result.size()))
            stored = failure(ErrorCode::LimitExceeded, "the result has " + std::to_string(result.size()) +
                                                           " bytes, more than there is room for (job-bytes)");
        else
            stored = store_.finish(job, result);
    }
    if (stored || result.empty()) return stored;
    job.status = JobStatus::Failed;
    job.failure = Problem{507, stored.error()};
    job.media_type.clear();
    job.result_bytes = 0;
    return store_.finish(job, {});
}

/// Ends a job that does not run.
void Jobs::fail(const LivePointer& live, Problem failure) {
    Job job;
    {
        const std::lock_guard lock(mutex_);
        if (live->settling) return;
        live->settling = true;
        withdraw_locked(*live);
        job = live->job;
    }
    job.status = JobStatus::Failed;
    job.failure = std::move(failure);
    settle(live, std::move(job), {}, {});
}

/// Takes a job out of the queues, or tells its run to stop.
/// @returns  whether it was not running
bool Jobs::withdraw_locked(Live& live) {
    if (!live.handed) {
        queue_.withdraw([&](const LivePointer& waiting) { return waiting.get() == &live; });
        return true;
    }
    if (pool_.cancel(*live.handed) != WorkerPool::Cancelled::Queued) return false;
    hand_next_locked();
    return true;
}

Jobs::LivePointer Jobs::find_live_locked(const std::string& id, const std::string& owner) const {
    const auto found = live_.find(id);
    return found == live_.end() || found->second->job.owner != owner ? nullptr : found->second;
}

HttpResult<Job> Jobs::find(const std::string& id, const std::string& owner) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto live = find_live_locked(id, owner)) return live->job;
    }
    auto found = store_.find(id);
    if (!found) return store_problem(found.error());
    const bool is_there = *found && (*found)->owner == owner;
    if (!is_there || ((*found)->finished && *(*found)->finished + limits_.ttl <= time_now())) return no_such_job();
    return **std::move(found);
}

HttpResult<std::string> Jobs::result(const std::string& id) {
    auto result = store_.result(id);
    if (!result) return store_problem(result.error());
    if (!*result) return problem(410, "the result was dropped to make room for others (job-bytes)");
    return **std::move(result);
}

HttpResult<void> Jobs::remove(const std::string& id, const std::string& owner) {
    LivePointer live;
    Job job;
    {
        std::unique_lock lock(mutex_);
        live = find_live_locked(id, owner);
        if (live && live->settling) {
            live->changed.wait(lock, [&] { return is_finished(live->job.status); });
            live_.erase(id);
            live.reset();
        } else if (live) {
            live->settling = true;
            withdraw_locked(*live);
            job = live->job;
        }
    }
    if (live) {
        job.status = JobStatus::Cancelled;
        settle(live, std::move(job), {}, {});
        return {};
    }
    if (auto found = find(id, owner); !found) return tl::unexpected(std::move(found.error()));
    if (auto removed = store_.remove(id); !removed) return store_problem(removed.error());
    return {};
}

HttpResult<Jobs::Watch> Jobs::watch(const std::string& id, const std::string& owner) const {
    {
        const std::lock_guard lock(mutex_);
        if (auto live = find_live_locked(id, owner)) return Watch(*this, std::move(live));
    }
    auto found = find(id, owner);
    if (!found) return tl::unexpected(std::move(found.error()));
    const auto live = std::make_shared<Live>();
    live->job = *std::move(found);
    return Watch(*this, live);
}

std::optional<Job> Jobs::Watch::next(Clock::time_point until) {
    std::unique_lock lock(jobs_.mutex_);
    const auto has_ended = [this] { return is_finished(live_->job.status); };
    const auto has_steps = [this] { return seen_ && *seen_ < live_->steps.size(); };
    const auto has_news = [&] { return !seen_ || has_steps() || (has_ended() && !over_); };
    if (!live_->changed.wait_until(lock, until, has_news)) return std::nullopt;
    Job job = live_->job;
    if (has_steps()) {
        job.status = JobStatus::Running;
        job.finished.reset();
        job.failure.reset();
        job.progress = live_->steps[(*seen_)++];
        return job;
    }
    seen_ = live_->steps.size();
    over_ = has_ended();
    return job;
}

void Jobs::drain() {
    std::vector<LivePointer> lost;
    {
        const std::lock_guard lock(mutex_);
        if (std::exchange(draining_, true)) return;
        for (const auto& [id, live] : live_) {
            if (!survives_) lost.push_back(live);
            if (!survives_ || live->settling || !live->handed) continue;
            live->stop = Stop::Shutdown;
            withdraw_locked(*live);
        }
    }
    for (const auto& live : lost) fail(live, {503, {ErrorCode::Stopped, "the server shut down", {}}});
}

bool Jobs::is_draining() const {
    const std::lock_guard lock(mutex_);
    return draining_;
}

Jobs::Counts Jobs::counts() const {
    const std::lock_guard lock(mutex_);
    Counts counts;
    for (const auto& [id, live] : live_) {
        if (live->job.status == JobStatus::Queued) ++counts.queued;
        if (live->job.status == JobStatus::Running) ++counts.running;
    }
    return counts;
}

void Jobs::keep_time(const std::stop_token& closing) {
    while (!closing.stop_requested()) {
        const auto expiry = forget_expired();
        std::unique_lock lock(mutex_);
        auto until = Clock::now() + kLongestSleep;
        if (const auto deadline = stop_overdue_locked()) until = std::min(until, *deadline);
        if (expiry) until = std::min(until, Clock::now() + std::max(*expiry - time_now(), kShortestSleep));
        wake_timekeeper_.wait_until(lock, closing, until, [this] { return news_; });
        news_ = false;
    }
}

/// @returns  when the next run has to end
std::optional<Jobs::Clock::time_point> Jobs::stop_overdue_locked() {
    std::optional<Clock::time_point> next;
    for (const auto& [id, live] : live_) {
        if (!live->deadline || live->settling || live->stop != Stop::None) continue;
        if (*live->deadline > Clock::now()) {
            next = std::min(next.value_or(*live->deadline), *live->deadline);
            continue;
        }
        live->stop = Stop::Deadline;
        pool_.cancel(*live->handed);
    }
    return next;
}

/// @returns  when the next job expires
std::optional<Time> Jobs::forget_expired() {
    while (store_.remove_finished(time_now() - limits_.ttl, kForgottenAtOnce).value_or(0) == kForgottenAtOnce) {
    }
    const auto first = store_.first_finished().value_or(std::nullopt);
    if (!first) return std::nullopt;
    return *first + limits_.ttl;
}

}  // namespace ccdt::server

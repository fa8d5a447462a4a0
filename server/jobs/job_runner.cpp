// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_runner.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <utility>

#include "server/requests/answer_headers.h"
#include "server/requests/convergence.h"

namespace ccdt::server {
namespace {

using Clock = ClaimedRuns::Clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// Maximum number of runs of a job that a server crash or a temporary fault may interrupt; after these, the job fails.
constexpr int kMaxStarts = 3;

/// Bounds of the interval at which expired jobs are deleted. Clients cannot find expired jobs even before their
/// deletion.
constexpr std::chrono::milliseconds kMinRemovalInterval{100};
constexpr std::chrono::milliseconds kMaxRemovalInterval{60'000};

Problem too_late(std::chrono::milliseconds timeout) {
    return {504,
            {ErrorCode::Stopped,
             "the computation took longer than the timeout of " + std::to_string(timeout.count()) + " ms (job-timeout)",
             {}}};
}

/// Returns the request of a job as read from the store. Error: Internal if the store failed or has lost the request.
Result<ComputeRequest> whole_request(Result<std::optional<ComputeRequest>> stored) {
    if (!stored) return failure(ErrorCode::Internal, stored.error().message);
    if (!*stored) return failure(ErrorCode::Internal, "the request is lost");
    return **std::move(stored);
}

Problem shut_down() {
    return {503, {ErrorCode::Stopped, "the server shut down", {}}};
}

/// Returns the end of a job that failed without a result.
JobEnd failed(Job job, Problem failure) {
    JobEnd end{std::move(job), {}, {}, failure.cause};
    end.job.status = JobStatus::Failed;
    end.job.failure = std::move(failure);
    return end;
}

/// Returns the end of a job that failed because its result could not be stored.
JobEnd not_stored(Job job, const Error& error) {
    JobEnd end{std::move(job), {}, {}, error.message};
    end.job.status = JobStatus::Failed;
    end.job.failure = Problem{507, error};
    end.job.media_type.clear();
    end.job.result_bytes = 0;
    return end;
}

}  // namespace

/// Stores all but the last piece of a result while it is computed. During an outage of the store, the computation
/// waits.
class JobRunner::ResultWriter : public api::BodySink {
public:
    ResultWriter(JobStore& store, const Job& job, std::stop_token stop)
        : store_(store), job_(job), stop_(std::move(stop)) {}

    Result<void> begin(const api::Answer& /*head*/) override { return {}; }

    Result<void> write(std::string_view piece) override {
        while (!piece.empty()) {
            const auto more = piece.substr(0, JobStore::kPiece - last_.size());
            last_ += more;
            piece.remove_prefix(more.size());
            if (last_.size() < JobStore::kPiece) continue;
            if (auto stored = store(); !stored) return stored;
        }
        return {};
    }

    /// Returns the part of the result that is stored. take_last() returns the rest, error() the error if storing
    /// failed.
    const JobStore::StoredPart& stored() const { return stored_; }
    std::string take_last() { return std::move(last_); }
    const std::optional<Error>& error() const { return error_; }

private:
    Result<void> store() {
        auto stored = store_.append_piece(job_, stored_, last_);
        while (!stored && stored.error().code == ErrorCode::Stopped && wait())
            stored = store_.append_piece(job_, stored_, last_);
        if (!stored) {
            if (stored.error().code != ErrorCode::Stopped) error_ = stored.error();
            return tl::unexpected(stored.error());
        }
        if (!*stored) return failure(ErrorCode::Stopped, "the job was claimed by another server");
        ++stored_.pieces;
        stored_.bytes += last_.size();
        last_.clear();
        return {};
    }

    /// Pauses for kPollInterval; returns false if a stop was requested.
    bool wait() {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any never;
        never.wait_for(lock, stop_, kPollInterval, [] { return false; });
        return !stop_.stop_requested();
    }

    JobStore& store_;
    const Job job_;
    const std::stop_token stop_;
    JobStore::StoredPart stored_;
    std::string last_;
    std::optional<Error> error_;
};

JobRunner::JobRunner(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute,
                     Logger logger, WatchedJobs& watched)
    : limits_(limits),
      store_(store),
      survives_(survives),
      pool_(pool),
      compute_(std::move(compute)),
      logger_(std::move(logger)),
      watched_(watched),
      renewal_interval_(std::max(limits.lease / 3, std::chrono::milliseconds(1))),
      runs_(std::max<std::size_t>(2, pool.load().workers) - 1),
      claimer_([this](const std::stop_token& closing) { claim_jobs(closing); }),
      timekeeper_([this](const std::stop_token& closing) { keep_time(closing); }) {}

JobRunner::~JobRunner() {
    drain();
    runs_.wait_until_pool_is_left();
}

void JobRunner::claim_jobs(const std::stop_token& closing) {
    const auto pause = std::min(kPollInterval, std::max(limits_.lease / 2, std::chrono::milliseconds(1)));
    while (!closing.stop_requested()) {
        while (claim_next()) {
        }
        runs_.wait_for_work(closing, pause);
    }
}

/// Claims the next job if the pool has capacity for it.
/// @returns  whether there may be another job to claim
bool JobRunner::claim_next() {
    if (!runs_.may_claim()) return false;
    // If no other server shares the store, claims jobs that are too large for this server, too, so that they fail.
    auto job = store_.claim(store_.is_shared() ? pool_.memory().total() : std::numeric_limits<std::size_t>::max());
    if (!job || !*job) return false;
    submit(**std::move(job));
    return true;
}

/// Passes a claimed job to the pool. If that is not possible, fails or requeues the job.
void JobRunner::submit(Job job) {
    std::optional<Problem> failure;
    if (job.starts > kMaxStarts)
        failure = Problem{500, {ErrorCode::Internal, "the server ended each time it ran this job", {}}};
    if (job.cost.memory > pool_.memory().total())
        failure = Problem{413, {ErrorCode::LimitExceeded, "this server has too little memory for this job", {}}};
    const auto run = std::make_shared<JobRun>(std::move(job));
    if (failure) run->start_settling();
    if (runs_.add(run, !failure)) {
        const Job added = run->job();
        const auto task = [this, run](WorkerPool::Turn& turn) { turn.used = this->run(run, turn.stop); };
        run->enter_pool([&] { return pool_.submit_always(added.client, task, added.cost); });
    } else if (failure) {
        settle(run, {{}, failed(run->job(), *std::move(failure))});
    } else if (survives_) {
        requeue(run);
    } else if (run->start_settling()) {
        settle(run, {{}, failed(run->job(), shut_down())});
    }
}

/// @returns  processor time in seconds; 0: unknown
double JobRunner::run(const Run& run, const std::stop_token& stop) {
    double used = 0;
    try {
        auto end = begin_run(run) ? compute(run, stop) : std::nullopt;
        if (end) {
            used = end->summary.stages.work.processor * 1e-3;
            end->summary.job.used = used;
            settle(run, *std::move(end));
        }
    } catch (const std::exception& exception) {
        settle(run, {{}, failed(run->job(), problem(500, exception.what()).value())});
    }
    runs_.leave_pool();
    return used;
}

/// Marks a run as started, in this server and in the store.
/// @returns  false if the job must not be run any more
bool JobRunner::begin_run(const Run& run) {
    Job job = run->job();
    job.status = JobStatus::Running;
    const auto renewal = store_.renew(job);
    if (renewal) give_up(run, renewal->owned);
    const auto next = run->begin(renewal, limits_.timeout);
    if (next == JobRun::Next::Requeue) requeue(run);
    if (next != JobRun::Next::Proceed) return false;
    runs_.wake_timekeeper();
    return true;
}

/// Computes the result of a job.
/// @returns  the end to be stored; none if the job was requeued, or is left to another thread or server
std::optional<JobRun::End> JobRunner::compute(const Run& run, const std::stop_token& stop) {
    Stages stages;
    const Job job = run->job();
    stages.queue = Milliseconds(*job.started - job.created).count();
    auto request = store_.request(job.id);
    if (!request && request.error().code == ErrorCode::Stopped) {
        requeue(run);
        return std::nullopt;
    }
    ResultWriter writer(store_, job, stop);
    Result<api::Answer> answer;
    std::string path;
    try {
        const Control control{stop, [&](const Progress& progress) { note(run, progress); }};
        answer = whole_request(std::move(request)).and_then([&](const ComputeRequest& whole) {
            path = whole.path;
            return compute_(whole, {.sink = &writer, .unwanted = run->unneeded()}, control, stages.work);
        });
        if (answer && !answer->streamed) {
            if (auto written = writer.write(answer->body); !written) answer = tl::unexpected(written.error());
        }
    } catch (const std::exception& exception) {
        answer = failure(ErrorCode::Internal, exception.what());
    }
    const bool whole = answer ? !answer->partial : answer.error().code != ErrorCode::Stopped;
    const bool is_temporary = !answer && answer.error().code == ErrorCode::Unavailable;
    const bool repeat = is_temporary && job.starts < kMaxStarts;
    const auto next = run->finish(whole, repeat);
    if (next == JobRun::Next::Requeue) requeue(run, repeat);
    if (next != JobRun::Next::Proceed) return std::nullopt;
    return end_of(run->job(), path, std::move(answer), writer, stages);
}

JobRun::End JobRunner::end_of(Job job, std::string_view path, Result<api::Answer> answer, ResultWriter& writer,
                              const Stages& stages) const {
    if (writer.error()) {
        JobEnd end = not_stored(std::move(job), *writer.error());
        end.stages = stages;
        return {{}, std::move(end)};
    }
    if (!answer) {
        const Error& error = answer.error();
        JobEnd end = failed(std::move(job),
                            error.code == ErrorCode::Stopped ? too_late(limits_.timeout) : problem(error).value());
        end.stages = stages;
        return {{}, std::move(end)};
    }
    job.status = JobStatus::Succeeded;
    job.progress.fraction = 1;
    job.media_type = std::move(answer->media_type);
    job.partial = answer->partial;
    job.headers = answer_headers(*answer);
    std::string result = writer.take_last();
    job.result_bytes = writer.stored().bytes + result.size();
    std::string doubt = doubt_about(*answer, path, job.progress.iteration, job.progress.variation.value_or(0));
    return {std::move(result),
            {std::move(job), stages, Computed{answer->sites, answer->pixels}, std::move(doubt)},
            writer.stored()};
}

void JobRunner::note(const Run& run, const Progress& progress) {
    if (run->note(progress)) runs_.wake_timekeeper();
    if (!run->is_gone()) watched_.advance(run->job());
}

/// Removes a run from the queue of the pool or, if it has started, requests it to stop.
/// @returns  true if the run had not started
bool JobRunner::cancel_in_pool(const Run& run) {
    const auto id = run->pool_id();
    if (!id || pool_.cancel(*id) != WorkerPool::Cancelled::Queued) return false;
    runs_.leave_pool();
    return true;
}

/// Stops and forgets a run if this server no longer owns the job.
void JobRunner::give_up(const Run& run, JobStore::Owned owned) {
    if (owned == JobStore::Owned::Still || !run->give_up(owned)) return;
    if (owned == JobStore::Owned::Lost) runs_.count_lost();
    cancel_in_pool(run);
    runs_.erase(run);
    watched_.mark_stale(run->job().id);
}

void JobRunner::drop(const std::string& id) {
    if (const auto run = runs_.find(id)) give_up(run, JobStore::Owned::Cancelled);
}

/// Returns a job to the store, for another run, process or server.
/// @param counted  see JobStore::requeue()
void JobRunner::requeue(const Run& run, bool counted) {
    (void)store_.requeue(run->job(), counted);  // if this fails, the job runs again when its lease expires
    runs_.erase(run);
}

/// Stores the end of a job, informs followers, and writes the log. No other thread may do the same, see
/// JobRun::start_settling().
void JobRunner::settle(const Run& run, JobRun::End end) {
    const auto stored = store_end(end);
    if (!stored && stored.error().code == ErrorCode::Stopped) return run->keep_end(std::move(end));
    runs_.erase(run);
    if (stored && !*stored) {
        if (!run->is_gone()) runs_.count_lost();
        return;
    }
    if (stored) {
        end.summary.job.finished = **stored;
        watched_.advance(end.summary.job);
    } else if (end.summary.cause.empty()) {
        end.summary.cause = stored.error().message;
    }
    logger_(end.summary);
}

/// Stores the end of a job. If the result cannot be stored, stores the job as failed, which needs no space.
Result<std::optional<Time>> JobRunner::store_end(JobRun::End& end) {
    auto stored = store_.finish(end.summary.job, end.result, end.before);
    const bool has_result = end.summary.job.result_bytes > 0;
    if (stored || !has_result || stored.error().code == ErrorCode::Stopped) return stored;
    end = {{}, not_stored(std::move(end.summary.job), stored.error())};
    return store_.finish(end.summary.job, {});
}

void JobRunner::fail_all() {
    while (auto job = store_.claim(std::numeric_limits<std::size_t>::max()).value_or(std::nullopt)) {
        const auto run = std::make_shared<JobRun>(*std::move(job));
        settle(run, {{}, failed(run->job(), shut_down())});
    }
}

void JobRunner::drain() {
    for (const auto& run : runs_.drain()) {
        if (survives_) {
            if (run->stop(JobRun::Stop::Shutdown) && cancel_in_pool(run)) requeue(run);
        } else if (run->start_settling()) {
            cancel_in_pool(run);
            settle(run, {{}, failed(run->job(), shut_down())});
        }
    }
    if (!survives_) fail_all();
}

void JobRunner::refresh() {
    for (const auto& run : runs_.all()) run->forget_stored_progress();
    runs_.wake_claimer();
    runs_.wake_timekeeper();
}

void JobRunner::add_latest(Job& job) const {
    if (const auto run = runs_.find(job.id)) run->add_latest(job);
}

void JobRunner::keep_time(const std::stop_token& closing) {
    const auto interval = std::clamp(limits_.ttl, kMinRemovalInterval, kMaxRemovalInterval);
    auto next_removal = Clock::now();
    auto settled = Clock::now();
    while (!closing.stop_requested()) {
        if (next_removal <= Clock::now()) {
            while (store_.remove_expired().value_or(false)) {
            }
            next_removal = Clock::now() + interval;
        }
        if (settled + kPollInterval <= Clock::now()) {
            store_remaining_ends();
            settled = Clock::now();
        }
        renew_leases();
        auto until = next_removal;
        for (const auto& run : runs_.all()) {
            if (run->is_overdue() && run->stop(JobRun::Stop::Deadline)) cancel_in_pool(run);
            if (run->has_end()) until = std::min(until, settled + kPollInterval);
            until = std::min(until, run->next_due(renewal_interval_));
        }
        runs_.wait_for_change(closing, until);
    }
}

void JobRunner::renew_leases() {
    for (const auto& run : runs_.all()) {
        const auto job = run->take_due(renewal_interval_);
        if (!job) continue;
        const auto renewal = store_.renew(*job);
        run->renewed(renewal.has_value());
        if (renewal) give_up(run, renewal->owned);
    }
}

/// Stores the ends of jobs that could not be stored during an outage of the store.
void JobRunner::store_remaining_ends() {
    for (const auto& run : runs_.all()) {
        auto end = run->take_end();
        if (!end) continue;
        settle(run, *std::move(end));
        runs_.wake_claimer();  // there may be capacity for other jobs
    }
}

}  // namespace ccdt::server

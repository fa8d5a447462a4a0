// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/jobs.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>

#include "server/work/answer_headers.h"
#include "server/work/form.h"

namespace ccdt::server {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

/// Maximum number of starts of a job that no server finishes. A computation cannot crash the server, so this guards
/// against unforeseen faults.
constexpr int kMaxStarts = 3;

/// Longest time until the server notices that the lease of another server has expired, or that the store can be reached
/// again.
constexpr std::chrono::milliseconds kLook{1000};

/// Interval at which a run's progress is stored.
constexpr std::chrono::milliseconds kProgressInterval{100};

/// Bounds of the interval between deletions of expired jobs. Clients cannot find an expired job, even before it is
/// deleted.
constexpr std::chrono::milliseconds kMinRemovalInterval{100};
constexpr std::chrono::milliseconds kMaxRemovalInterval{60'000};

/// Makes an id of 128 unpredictable bits, because the id is all that is needed to read the result.
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

/// Makes a problem of a failure of the store. The client is told the cause only if the data of its own job is damaged.
tl::unexpected<Problem> store_problem(const Error& error) {
    if (error.code == ErrorCode::Stopped) {
        auto away = busy(503, "the store of jobs cannot be reached", std::chrono::ceil<std::chrono::seconds>(kLook));
        away.value().cause = error.message;
        return away;
    }
    auto failed = problem(error.code == ErrorCode::LimitExceeded ? 507 : 500, error.message);
    if (error.code == ErrorCode::Unusable) failed.value().error.message = error.message;
    return failed;
}

tl::unexpected<Problem> no_such_job() {
    return problem(404, "there is no such job: it never existed, or it has expired");
}

Problem too_late(std::chrono::milliseconds timeout) {
    return {504,
            {ErrorCode::Stopped,
             "the computation took longer than the timeout of " + std::to_string(timeout.count()) + " ms (job-timeout)",
             {}}};
}

/// Returns the request that a store has found. Errors: Internal if the store failed or has no such request.
Result<ComputeRequest> whole_request(Result<std::optional<ComputeRequest>> stored) {
    if (!stored) return failure(ErrorCode::Internal, stored.error().message);
    if (!*stored) return failure(ErrorCode::Internal, "the request is lost");
    return **std::move(stored);
}

Problem shut_down() {
    return {503, {ErrorCode::Stopped, "the server shut down", {}}};
}

/// Makes the end of a job without a result.
JobEnd failed(Job job, Problem failure) {
    JobEnd end{std::move(job), {}, {}, failure.cause};
    end.job.status = JobStatus::Failed;
    end.job.failure = std::move(failure);
    return end;
}

/// Makes the end of a job whose result could not be stored.
JobEnd not_stored(Job job, const Error& error) {
    JobEnd end{std::move(job), {}, {}, error.message};
    end.job.status = JobStatus::Failed;
    end.job.failure = Problem{507, error};
    end.job.media_type.clear();
    end.job.result_bytes = 0;
    return end;
}

HttpResult<std::string> existing(Result<std::optional<std::string>> result) {
    if (!result) return store_problem(result.error());
    if (!*result) return problem(410, "the result was dropped to make room for others (job-bytes)");
    return **std::move(result);
}

}  // namespace

/// Stores a result while it is written, except for the last piece. While the store cannot be reached, the computation
/// waits.
class Jobs::ResultWriter : public api::BodySink {
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

    /// The part of the result that is stored, the part after it, and the error if storing failed.
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

    /// @returns  false if a stop was requested
    bool wait() {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any never;
        never.wait_for(lock, stop_, kLook, [] { return false; });
        return !stop_.stop_requested();
    }

    JobStore& store_;
    const Job job_;
    const std::stop_token stop_;
    JobStore::StoredPart stored_;
    std::string last_;
    std::optional<Error> error_;
};

Jobs::Jobs(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger)
    : limits_(limits),
      store_(store),
      survives_(survives),
      pool_(pool),
      compute_(std::move(compute)),
      logger_(std::move(logger)),
      at_once_(std::max<std::size_t>(2, pool.load().workers) - 1),
      claimer_([this](const std::stop_token& closing) { hand_out(closing); }),
      timekeeper_([this](const std::stop_token& closing) { keep_time(closing); }) {
    store_.listen(this);
}

Jobs::~Jobs() {
    drain();
    store_.listen(nullptr);
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return in_pool_ == 0; });
}

void Jobs::start() {
    const std::lock_guard lock(mutex_);
    started_ = true;
    has_work_ = true;
    wake_claimer_.notify_all();
}

bool Jobs::is_full(std::string_view client) const {
    return store_.is_full(client).value_or(false);
}

HttpResult<Job> Jobs::accept(Job job, const ComputeRequest& request) {
    if (is_draining() && !survives_) return busy(503, "the server is shutting down", pool_.backlog());
    job.id = new_id();
    if (auto added = add(job, request); !added) return tl::unexpected(std::move(added.error()));
    if (is_draining() && !survives_) fail_all();
    return job;
}

HttpResult<void> Jobs::add(Job& job, const ComputeRequest& request) {
    if (JobStore::bytes_of_job(JobStore::bytes_of(request)) > limits_.bytes)
        return problem(413, "the request is larger than the storage for jobs, " + std::to_string(limits_.bytes) +
                                " bytes (job-bytes)");
    if (JobStore::bytes_of_job(job.cost.answer) > limits_.bytes)
        return problem(413, "the result would have at least " + std::to_string(job.cost.answer) +
                                " bytes, more than the storage for jobs of " + std::to_string(limits_.bytes) +
                                " (job-bytes): request it without a job, or in another format");
    const auto added = store_.add(job, request);
    if (!added) return store_problem(added.error());
    if (*added == JobStore::Added::QueueFull)
        return busy(429, "too many jobs are waiting (job-queue)", pool_.backlog());
    if (*added == JobStore::Added::StoreFull)
        return busy(429, "waiting jobs take all the storage (job-bytes)", pool_.backlog());
    return {};
}

void Jobs::hand_out(const std::stop_token& closing) {
    const auto pause = std::min(kLook, std::max(limits_.lease / 2, std::chrono::milliseconds(1)));
    while (!closing.stop_requested()) {
        while (claim_next()) {
        }
        std::unique_lock lock(mutex_);
        wake_claimer_.wait_for(lock, closing, pause, [this] { return has_work_; });
        has_work_ = false;
    }
}

/// Claims a job if the pool has a worker for it.
/// @returns  whether there may be another job
bool Jobs::claim_next() {
    {
        const std::lock_guard lock(mutex_);
        if (!started_ || draining_ || in_pool_ + count_unstored_locked() >= at_once_) return false;
    }
    // A job that is too large for this server has to fail if no other server shares the store.
    auto job = store_.claim(store_.is_shared() ? pool_.memory().total() : std::numeric_limits<std::size_t>::max());
    if (!job || !*job) return false;
    submit(**std::move(job));
    return true;
}

/// Counts the jobs whose ends could not be stored yet.
std::size_t Jobs::count_unstored_locked() const {
    const auto count = std::ranges::count_if(runs_, [](const auto& run) { return run.second->unstored.has_value(); });
    return static_cast<std::size_t>(count);
}

/// Passes a claimed job to the pool.
void Jobs::submit(Job job) {
    std::optional<Problem> failure;
    if (job.starts > kMaxStarts)
        failure = Problem{500, {ErrorCode::Internal, "the server ended each time it ran this job", {}}};
    if (job.cost.memory > pool_.memory().total())
        failure = Problem{413, {ErrorCode::LimitExceeded, "this server has too little memory for this job", {}}};
    const auto run = std::make_shared<Run>();
    run->job = std::move(job);
    run->renewed = Clock::now();
    {
        const std::lock_guard lock(mutex_);
        if (draining_ && !survives_) failure = shut_down();
        runs_.insert_or_assign(run->job.id, run);
        if (run->job.starts > 1) ++counts_.repeated;
        run->settling = failure.has_value();
        if (!draining_ && !failure) {
            ++in_pool_;
            run->pool_id = pool_.submit_always(
                run->job.client, [this, run](const std::stop_token& stop) { this->run(run, stop); }, run->job.cost);
            return;
        }
    }
    if (failure)
        settle(run, {{}, failed(run->job, *std::move(failure))});
    else
        requeue(run);
}

void Jobs::run(const RunPointer& run, const std::stop_token& stop) {
    try {
        auto end = begin(run) ? compute(run, stop) : std::nullopt;
        if (end) settle(run, *std::move(end));
    } catch (const std::exception& exception) {
        settle(run, {{}, failed(run->job, problem(500, exception.what()).value())});
    }
    const std::lock_guard lock(mutex_);
    release_locked();
}

/// Updates the counts when a job has left the pool, so that another one can be claimed.
void Jobs::release_locked() {
    --in_pool_;
    has_work_ = true;
    wake_claimer_.notify_all();
    idle_.notify_all();
}

/// Marks a run as started, here and in the store.
/// @returns  false if the job must not be run any more
bool Jobs::begin(const RunPointer& run) {
    Job job;
    Stop stop{};
    {
        const std::lock_guard lock(mutex_);
        if (run->settling) return false;
        job = run->job;
        stop = run->stop;
    }
    if (stop == Stop::Shutdown) requeue(run);
    if (stop != Stop::None) return false;
    job.status = JobStatus::Running;
    const auto renewal = store_.renew(job);
    const std::lock_guard lock(mutex_);
    if (run->settling || (renewal && !check_owned_locked(run, renewal->owned))) return false;
    // If the store fails, the job runs nevertheless: no other server can claim the job before the lease expires.
    run->job.status = JobStatus::Running;
    run->job.started =
        renewal ? renewal->now
                : std::max(time_now(), job.created);  // the store's clock, which set job.created, may be ahead
    run->renewed = Clock::now();
    run->deadline = run->renewed + limits_.timeout;
    runs_changed_ = true;
    wake_timekeeper_.notify_all();
    return true;
}

/// Gives up a run if this server no longer owns the job.
/// @returns  false if the run was given up
bool Jobs::check_owned_locked(const RunPointer& run, JobStore::Owned owned) {
    if (owned == JobStore::Owned::Still || run->settling) return true;
    if (owned == JobStore::Owned::Lost && run->stop != Stop::Gone) ++counts_.lost;
    drop_locked(run);
    followed_.mark_stale(run->job.id);
    return false;
}

/// Drops a run. If another thread is storing the end of the job at this moment, the store will refuse that end.
void Jobs::drop_locked(const RunPointer& run) {
    if (run->settling) {
        run->stop = Stop::Gone;
        return;
    }
    run->unneeded.request_stop();
    stop_locked(*run, Stop::Gone);
    erase_locked(run);
}

void Jobs::erase_locked(const RunPointer& run) {
    const auto found = runs_.find(run->job.id);
    if (found != runs_.end() && found->second == run) runs_.erase(found);
}

/// Removes a run from the queue of the pool, or requests it to stop if it has started.
/// @returns  true if it had not started
bool Jobs::stop_locked(Run& run, Stop why) {
    run.stop = why;
    if (!run.pool_id || pool_.cancel(*run.pool_id) != WorkerPool::Cancelled::Queued) return false;
    release_locked();
    return true;
}

/// Computes the result of a job.
/// @returns  none if this run does not end the job
std::optional<Jobs::End> Jobs::compute(const RunPointer& run, const std::stop_token& stop) {
    Stages stages;
    stages.queue = Milliseconds(*run->job.started - run->job.created).count();
    auto request = store_.request(run->job.id);
    if (!request && request.error().code == ErrorCode::Stopped) {
        requeue(run);
        return std::nullopt;
    }
    ResultWriter writer(store_, run->job, stop);
    Result<api::Answer> answer;
    try {
        const Control control{stop, [&](const Progress& progress) { note(run, progress); }};
        answer = whole_request(std::move(request)).and_then([&](const ComputeRequest& whole) {
            return compute_(whole, {.sink = &writer, .unwanted = run->unneeded.get_token()}, control, stages.work);
        });
        if (answer && !answer->streamed) {
            if (auto written = writer.write(answer->body); !written) answer = tl::unexpected(written.error());
        }
    } catch (const std::exception& exception) {
        answer = failure(ErrorCode::Internal, exception.what());
    }
    std::unique_lock lock(mutex_);
    run->deadline.reset();
    if (run->settling || run->stop == Stop::Gone) return std::nullopt;
    const bool whole = answer ? !answer->partial : answer.error().code != ErrorCode::Stopped;
    if (run->stop == Stop::Shutdown && !whole) {
        lock.unlock();
        requeue(run);
        return std::nullopt;
    }
    run->settling = true;
    return end_of(run->job, std::move(answer), writer, stages);
}

Jobs::End Jobs::end_of(Job job, Result<api::Answer> answer, ResultWriter& writer, const Stages& stages) const {
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
    return {std::move(result), {std::move(job), stages, Computed{answer->sites, answer->pixels}, {}}, writer.stored()};
}

void Jobs::note(const RunPointer& run, const Progress& progress) {
    const std::lock_guard lock(mutex_);
    if (run->settling || run->stop == Stop::Gone) return;
    run->job.progress = {progress.done(), progress.iteration, progress.variation};
    followed_.advance(run->job);
    if (!std::exchange(run->progress_stored, false)) return;
    runs_changed_ = true;
    wake_timekeeper_.notify_all();
}

/// Returns a job to the store, for the next process or another server.
void Jobs::requeue(const RunPointer& run) {
    (void)store_.requeue(run->job);  // if this fails, the job runs again when its lease expires
    const std::lock_guard lock(mutex_);
    erase_locked(run);
}

/// Stores the end of a job, informs followers, and writes the log. The caller must have set `settling`.
void Jobs::settle(const RunPointer& run, End end) {
    const auto stored = store_end(end);
    Job& job = end.summary.job;
    {
        const std::lock_guard lock(mutex_);
        if (!stored && stored.error().code == ErrorCode::Stopped) {
            run->unstored = std::move(end);
            return;
        }
        erase_locked(run);
        if (stored && *stored) {
            job.finished = **stored;
            followed_.advance(job);
        } else if (stored) {
            if (run->stop != Stop::Gone) ++counts_.lost;
            return;
        }
    }
    if (!stored && end.summary.cause.empty()) end.summary.cause = stored.error().message;
    logger_(end.summary);
}

/// Stores the end of a job. If the result cannot be stored, the job is stored as failed, which needs no space.
Result<std::optional<Time>> Jobs::store_end(End& end) {
    auto stored = store_.finish(end.summary.job, end.result, end.before);
    const bool has_result = end.summary.job.result_bytes > 0;
    if (stored || !has_result || stored.error().code == ErrorCode::Stopped) return stored;
    end = {{}, not_stored(std::move(end.summary.job), stored.error())};
    return store_.finish(end.summary.job, {});
}

/// Fails all jobs that no server runs.
void Jobs::fail_all() {
    while (auto job = store_.claim(std::numeric_limits<std::size_t>::max()).value_or(std::nullopt)) {
        const auto run = std::make_shared<Run>();
        run->job = *std::move(job);
        settle(run, {{}, failed(run->job, shut_down())});
    }
}

HttpResult<Job> Jobs::find(const std::string& id, const std::string& owner) const {
    auto found = store_.find(id);
    if (!found) return store_problem(found.error());
    if (!*found || (*found)->owner != owner) return no_such_job();
    Job job = **std::move(found);
    add_latest(job);
    return job;
}

/// Adds progress that the store does not have yet.
void Jobs::add_latest(Job& job) const {
    const std::lock_guard lock(mutex_);
    const auto found = runs_.find(job.id);
    if (found == runs_.end() || is_finished(job.status) || found->second->job.claim != job.claim) return;
    job.status = found->second->job.status;
    job.started = found->second->job.started;
    job.progress = found->second->job.progress;
}

HttpResult<std::string> Jobs::result(const std::string& id) {
    return existing(store_.result(id));
}

HttpResult<std::string> Jobs::piece(const std::string& id, std::size_t number) {
    return existing(store_.piece(id, number));
}

HttpResult<void> Jobs::remove(const std::string& id, const std::string& owner) {
    const auto found = find(id, owner);
    if (!found) return tl::unexpected(found.error());
    if (!is_finished(found->status)) {
        const auto cancelled = store_.cancel(id);
        if (!cancelled) return store_problem(cancelled.error());
        if (*cancelled) {
            stop(id);
            const Job& job = **cancelled;
            followed_.advance(job);
            logger_({job, {}, {}, {}});
            return {};
        }
    }
    if (auto removed = store_.remove(id); !removed) return store_problem(removed.error());
    return {};
}

void Jobs::work() {
    const std::lock_guard lock(mutex_);
    has_work_ = true;
    wake_claimer_.notify_all();
}

void Jobs::changed(const std::string& id) {
    followed_.mark_stale(id);
}

void Jobs::stop(const std::string& id) {
    const std::lock_guard lock(mutex_);
    if (const auto found = runs_.find(id); found != runs_.end()) drop_locked(RunPointer(found->second));
}

void Jobs::missed() {
    followed_.mark_all_stale();
    const std::lock_guard lock(mutex_);
    for (const auto& [id, run] : runs_) run->progress_stored = false;
    has_work_ = runs_changed_ = true;
    wake_claimer_.notify_all();
    wake_timekeeper_.notify_all();
}

HttpResult<Jobs::Watch> Jobs::watch(const std::string& id, const std::string& owner) {
    const auto followed = followed_.follow(id);  // first, so that no notification is missed
    const auto job = find(id, owner);
    if (!job) return tl::unexpected(job.error());
    followed->advance(*job);
    return Watch(followed, [this](const std::string& job_id, FollowedJob& known) { look_again(job_id, known); });
}

/// Asks the store for the state of a job, which another server may run.
void Jobs::look_again(const std::string& id, FollowedJob& followed) const {
    auto found = store_.find(id);
    if (!found) return;  // once the store can be reached again, missed() is called
    if (*found) {
        add_latest(**found);
        followed.advance(**found);
    } else {
        followed.mark_gone();
    }
}

void Jobs::drain() {
    std::vector<RunPointer> left;
    {
        const std::lock_guard lock(mutex_);
        if (std::exchange(draining_, true)) return;
        for (const auto& [id, run] : runs_) {
            if (run->settling) continue;
            const bool waited = stop_locked(*run, Stop::Shutdown);
            run->settling = !survives_;
            if (waited || !survives_) left.push_back(run);
        }
    }
    for (const auto& run : left) {
        if (survives_)
            requeue(run);
        else
            settle(run, {{}, failed(run->job, shut_down())});
    }
    if (!survives_) fail_all();
}

bool Jobs::is_draining() const {
    const std::lock_guard lock(mutex_);
    return draining_;
}

std::optional<JobStore::Load> Jobs::load() const {
    const auto load = store_.load();
    return load ? std::optional(*load) : std::nullopt;
}

Jobs::Counts Jobs::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

void Jobs::keep_time(const std::stop_token& closing) {
    const auto interval = std::clamp(limits_.ttl, kMinRemovalInterval, kMaxRemovalInterval);
    auto next_removal = Clock::now();
    auto settled = Clock::now();
    while (!closing.stop_requested()) {
        if (next_removal <= Clock::now()) {
            while (store_.remove_expired().value_or(false)) {
            }
            next_removal = Clock::now() + interval;
        }
        if (settled + kLook <= Clock::now()) {
            store_remaining_ends();
            settled = Clock::now();
        }
        renew_leases();
        std::unique_lock lock(mutex_);
        const auto next_settling = count_unstored_locked() > 0 ? settled + kLook : next_removal;
        const auto until = std::min({next_removal, next_settling, stop_overdue_locked(), next_renewal_locked()});
        wake_timekeeper_.wait_until(lock, closing, until, [this] { return runs_changed_; });
        runs_changed_ = false;
    }
}

/// Stops the runs whose deadlines have passed.
/// @returns  the next deadline of a run
Jobs::Clock::time_point Jobs::stop_overdue_locked() {
    auto next = Clock::time_point::max();
    for (const auto& [id, run] : runs_) {
        if (!run->deadline || run->settling || run->stop != Stop::None) continue;
        if (*run->deadline > Clock::now())
            next = std::min(next, *run->deadline);
        else
            stop_locked(*run, Stop::Deadline);
    }
    return next;
}

/// Computes when to renew a run's lease or store its progress.
Jobs::Clock::time_point Jobs::next_renewal_locked(const Run& run) const {
    const auto renewal = std::max(limits_.lease / 3, std::chrono::milliseconds(1));
    return run.renewed + (run.progress_stored ? renewal : std::min(kProgressInterval, renewal));
}

Jobs::Clock::time_point Jobs::next_renewal_locked() const {
    auto next = Clock::time_point::max();
    for (const auto& [id, run] : runs_) next = std::min(next, next_renewal_locked(*run));
    return next;
}

void Jobs::renew_leases() {
    std::vector<std::pair<RunPointer, Job>> due;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [id, run] : runs_)
            if (next_renewal_locked(*run) <= Clock::now()) due.emplace_back(run, run->job);
        for (const auto& [run, job] : due) run->progress_stored = true;
    }
    for (const auto& [run, job] : due) {
        const auto renewal = store_.renew(job);
        const std::lock_guard lock(mutex_);
        run->renewed = Clock::now();
        if (renewal)
            check_owned_locked(run, renewal->owned);
        else
            run->progress_stored = false;
    }
}

/// Tries again to store the ends of jobs that could not be stored before.
void Jobs::store_remaining_ends() {
    std::vector<std::pair<RunPointer, End>> remaining;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& [id, run] : runs_)
            if (auto end = std::exchange(run->unstored, std::nullopt)) remaining.emplace_back(run, *std::move(end));
    }
    for (auto& [run, end] : remaining) settle(run, std::move(end));
    if (remaining.empty()) return;
    work();  // there may be capacity for other jobs
}

}  // namespace ccdt::server

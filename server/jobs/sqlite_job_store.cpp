// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sqlite_job_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <type_traits>
#include <utility>

#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

/// Number of jobs that one call deletes; more would delay other calls.
constexpr std::size_t kRemovedAtOnce = 100;

constexpr const char* kFile = "/jobs.sqlite";

ErrorCode code_of(const SqliteError& error) {
    switch (error.code()) {
        case SQLITE_FULL:
        case SQLITE_TOOBIG:
            return ErrorCode::LimitExceeded;
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB:
            return ErrorCode::Unusable;
        default:
            return ErrorCode::Internal;
    }
}

/// Creates the file, with read and write access only for its owner.
Result<void> make_file(const std::string& folder, const std::string& path) {
    const auto failed = [](const std::string& name) {
        return failure(ErrorCode::Unusable, "the data folder cannot be used: " + name + ": " + std::strerror(errno));
    };
    if (mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) return failed(folder);
    if (!UniqueFd(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR))) return failed(path);
    return {};
}

}  // namespace

Result<std::unique_ptr<SqliteJobStore>> SqliteJobStore::open(const std::string& folder, const JobLimits& limits) {
    const std::string path = folder.empty() ? ":memory:" : folder + kFile;
    if (!folder.empty()) {
        if (auto made = make_file(folder, path); !made) return tl::unexpected(made.error());
    }
    try {
        return std::unique_ptr<SqliteJobStore>(new SqliteJobStore(path, limits));
    } catch (const SqliteError& error) {
        const std::string reason = error.code() == SQLITE_BUSY ? "another server uses it" : error.what();
        return failure(ErrorCode::Unusable, "the jobs of " + path + " cannot be used: " + reason);
    }
}

SqliteJobStore::SqliteJobStore(const std::string& path, const JobLimits& limits)
    : limits_(limits), tables_(path), queue_(limits) {
    for (const Job& job : tables_.unfinished()) queue_.push(job);
}

template <class Do>
auto SqliteJobStore::attempt(Do act) -> Result<decltype(act())> {
    const std::lock_guard lock(mutex_);
    try {
        if constexpr (std::is_void_v<decltype(act())>) {
            act();
            return {};
        } else {
            return act();
        }
    } catch (const SqliteError& error) {
        const ErrorCode code = code_of(error);
        if (code == ErrorCode::Unusable) ++damages_;
        if (code == ErrorCode::LimitExceeded) tables_.cut_log();
        return failure(code, std::string("the job store: ") + error.what());
    } catch (const std::exception& exception) {  // most likely out of memory
        return failure(ErrorCode::Internal, std::string("the job store: ") + exception.what());
    }
}

/// Calls `act`, which frees space, and repeats the call once if the disk is full. Then returns free pages to the disk.
template <class Do>
auto SqliteJobStore::run_freeing(Do act) -> Result<decltype(act())> {
    auto done = attempt(act);
    if (!done && done.error().code == ErrorCode::LimitExceeded) done = attempt(act);  // attempt() has emptied the log
    while (done && attempt([this] { return tables_.return_free_pages(); }).value_or(false)) {
    }
    return done;
}

Result<bool> SqliteJobStore::is_full(std::string_view client) {
    const std::lock_guard lock(mutex_);
    return !queue_.accepts_job_of(client);
}

Result<JobStore::Added> SqliteJobStore::add(Job& job, const ComputeRequest& request) {
    const std::size_t bytes = bytes_of_job(bytes_of(request));
    const std::lock_guard space_lock(space_mutex_);
    if (is_full(job.client).value()) return Added::QueueFull;
    if (!free_space(bytes)) return Added::StoreFull;
    auto added = attempt([&] {
        if (tables_.find(job.id)) return Added::Accepted;
        job.created = time_now();
        tables_.insert(job, request, limits_.bytes);
        queue_.push(job);
        return Added::Accepted;
    });
    if (added == Added::Accepted) notifier_.notify([](JobListener& listener) { listener.work(); });
    return added;
}

/// Deletes the oldest results and then, if needed, the oldest finished jobs. Returns whether `bytes` are free.
bool SqliteJobStore::free_space(std::size_t bytes) {
    const auto is_enough = [&] { return tables_.bytes() + bytes <= limits_.bytes; };
    const auto drop = [&] {
        if (run_freeing([this] { return tables_.drop_oldest_result(); }).value_or(false)) return true;
        return run_freeing([this] { return tables_.remove_finished(Time::max(), 1); }).value_or(0) > 0;
    };
    while (!is_enough() && drop()) {
    }
    return is_enough();
}

Result<std::optional<Job>> SqliteJobStore::claim(std::size_t memory) {
    return attempt([&]() -> std::optional<Job> {
        while (auto entry = queue_.take_next(memory))
            if (auto job = begin(*std::move(entry))) return job;
        return std::nullopt;
    });
}

/// Claims a job that was taken from the queue, and counts its start.
/// @returns  none if the job cannot be run, because its data is damaged
std::optional<Job> SqliteJobStore::begin(JobQueue::Entry entry) {
    try {
        auto stored = tables_.find(entry.item.id);
        if (!stored) return std::nullopt;
        Job& job = stored->job;
        job.status = JobStatus::Queued;
        job.started.reset();
        job.progress = {};
        ++job.starts;
        tables_.restart(*stored);
        queue_.claim(std::move(entry), job);
        return std::move(job);
    } catch (const SqliteError& error) {
        if (code_of(error) != ErrorCode::Unusable) {
            queue_.put_back(std::move(entry));
            throw;
        }
        ++damages_;
        return std::nullopt;
    }
}

Result<JobStore::Renewal> SqliteJobStore::renew(const Job& job) {
    auto renewal = attempt([&] {
        const Time now = time_now();
        if (queue_.renew(job, now)) return Renewal{Owned::Still, now};
        const auto stored = tables_.find(job.id);
        return Renewal{stored && stored->job.status == JobStatus::Cancelled ? Owned::Cancelled : Owned::Lost, now};
    });
    if (renewal && renewal->owned == Owned::Still)
        notifier_.notify([&](JobListener& listener) { listener.changed(job.id); });
    return renewal;
}

Result<void> SqliteJobStore::requeue(const Job& job, bool counted) {
    auto requeued = attempt([&] {
        if (!queue_.requeue(job) || counted) return;
        auto stored = tables_.find(job.id);
        if (!stored) return;
        --stored->job.starts;
        tables_.update(*stored);
    });
    notifier_.notify([&](JobListener& listener) {
        listener.changed(job.id);
        listener.work();
    });
    return requeued;
}

/// Finds a job with its current state. The state of a claimed job comes from the queue, because the database does not
/// contain its progress.
std::optional<SqliteJobTables::StoredJob> SqliteJobStore::find_stored(const std::string& id) {
    auto stored = tables_.find(id);
    if (!stored) return std::nullopt;
    Job& job = stored->job;
    if (job.finished) return *job.finished + limits_.ttl <= time_now() ? std::nullopt : std::move(stored);
    if (const Job* const claimed = queue_.find(id)) {
        job = *claimed;
        return stored;
    }
    job.status = JobStatus::Queued;
    job.started.reset();
    job.progress = {};
    return stored;
}

Result<std::optional<Job>> SqliteJobStore::find(const std::string& id) {
    return attempt([&]() -> std::optional<Job> {
        auto stored = find_stored(id);
        if (!stored) return std::nullopt;
        return std::move(stored->job);
    });
}

Result<std::optional<ComputeRequest>> SqliteJobStore::request(const std::string& id) {
    return attempt([&] { return tables_.request(id); });
}

Result<std::optional<std::string>> SqliteJobStore::piece(const std::string& id, std::size_t number) {
    return attempt([&] { return tables_.piece(id, number); });
}

Result<bool> SqliteJobStore::append_piece(const Job& job, const StoredPart& before, std::string_view piece) {
    const std::size_t whole = before.bytes + piece.size();
    if (bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::lock_guard space_lock(space_mutex_);
    if (!free_space(piece.size())) return no_space_for(whole);
    return attempt([&] {
        const auto stored = queue_.owns(job) ? tables_.find(job.id) : std::nullopt;
        if (stored) tables_.append(*stored, before.pieces, piece);
        return stored.has_value();
    });
}

Result<std::optional<Time>> SqliteJobStore::finish(const Job& job, std::string_view result, const StoredPart& before) {
    const std::size_t whole = before.bytes + result.size();
    if (whole > 0 && bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::lock_guard space_lock(space_mutex_);
    if (!result.empty() && !free_space(result.size())) return no_space_for(whole);
    auto finished = attempt([&]() -> std::optional<Time> {
        const auto stored = queue_.owns(job) ? tables_.find(job.id) : std::nullopt;
        if (!stored) return std::nullopt;
        Job ended = job;
        ended.finished = time_now();
        ended.result_bytes = whole;
        tables_.finish(ended, *stored, result, before);
        queue_.finish(job);
        return ended.finished;
    });
    if (finished && *finished) notifier_.notify([&](JobListener& listener) { listener.changed(job.id); });
    return finished;
}

Result<std::optional<Job>> SqliteJobStore::cancel(const std::string& id) {
    auto cancelled = run_freeing([&]() -> std::optional<Job> {
        auto stored = find_stored(id);
        if (!stored || stored->job.finished) return std::nullopt;
        Job job = std::move(stored->job);
        job.status = JobStatus::Cancelled;
        job.finished = time_now();
        tables_.finish(job, *stored, {});
        queue_.withdraw(id);
        return job;
    });
    if (cancelled && *cancelled) {
        notifier_.notify([&](JobListener& listener) {
            listener.stop(id);
            listener.changed(id);
        });
    }
    return cancelled;
}

Result<std::optional<JobStore::Webhook>> SqliteJobStore::claim_webhook(std::chrono::milliseconds lease) {
    return attempt([&, now = time_now()] { return tables_.claim_webhook(now, now + lease); });
}

Result<void> SqliteJobStore::settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) {
    return attempt([&] { tables_.settle_webhook(id, pause ? std::optional(time_now() + *pause) : std::nullopt); });
}

Result<bool> SqliteJobStore::remove(const std::string& id) {
    return run_freeing([&] {
        const bool existed = tables_.remove(id);
        if (existed) queue_.withdraw(id);
        return existed;
    });
}

Result<bool> SqliteJobStore::remove_expired() {
    const auto remove = [this](std::size_t max_jobs) {
        return run_freeing([&] { return tables_.remove_finished(time_now() - limits_.ttl, max_jobs); });
    };
    auto removed = remove(kRemovedAtOnce);
    if (!removed && removed.error().code == ErrorCode::LimitExceeded) removed = remove(1);
    return removed.map([](std::size_t count) { return count == kRemovedAtOnce; });
}

Result<JobStore::Load> SqliteJobStore::load() {
    const std::lock_guard lock(mutex_);
    return Load{queue_.queued(), queue_.claimed(), tables_.bytes()};
}

}  // namespace ccdt::server

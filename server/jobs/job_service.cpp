// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <sys/random.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace ccdt::server {
namespace {

/// Makes an id of 128 random bits in hexadecimal. Without API keys, anybody who knows the id can read the result.
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

/// Converts an error of the store to a problem. The client learns the cause only if the job is damaged.
tl::unexpected<Problem> store_problem(const Error& error) {
    if (error.code == ErrorCode::Stopped) {
        auto away = busy(503, "the store of jobs cannot be reached",
                         std::chrono::ceil<std::chrono::seconds>(JobRunner::kPollInterval));
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

HttpResult<std::string> existing(Result<std::optional<std::string>> result) {
    if (!result) return store_problem(result.error());
    if (!*result) return problem(410, "the result was dropped to free space for others (job-bytes)");
    return **std::move(result);
}

}  // namespace

JobService::JobService(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute,
                       Logger logger)
    : limits_(limits),
      store_(store),
      survives_(survives),
      pool_(pool),
      logger_(logger),
      runner_(limits, store, survives, pool, std::move(compute), std::move(logger), watched_) {
    store_.listen(this);
}

JobService::~JobService() {
    runner_.drain();
    store_.listen(nullptr);
}

bool JobService::is_full(std::string_view client) const {
    return store_.is_full(client).value_or(false);
}

HttpResult<Job> JobService::accept(Job job, const ComputeRequest& request) {
    if (is_draining() && !survives_) return busy(503, "the server is shutting down", pool_.backlog());
    job.id = new_id();
    if (auto added = add(job, request); !added) return tl::unexpected(std::move(added.error()));
    if (is_draining() && !survives_) runner_.fail_all();
    return job;
}

HttpResult<void> JobService::add(Job& job, const ComputeRequest& request) {
    if (JobStore::bytes_of_job(JobStore::bytes_of(request)) > limits_.bytes)
        return problem(413, "the request is larger than the storage for jobs, " + std::to_string(limits_.bytes) +
                                " bytes (job-bytes)");
    if (JobStore::bytes_of_job(job.cost.answer) > limits_.bytes)
        return problem(413, "the result would have at least " + std::to_string(job.cost.answer) +
                                " bytes, more than the storage for jobs of " + std::to_string(limits_.bytes) +
                                " (job-bytes): request it without a job, or in another format");
    const auto added = store_.add(job, request);
    if (!added && added.error().code == ErrorCode::LimitExceeded)
        return problem(507, "there is no space for this job and its result beside those of waiting jobs: " +
                                added.error().message);
    if (!added) return store_problem(added.error());
    if (*added == JobStore::Added::QueueFull)
        return busy(429, "too many jobs are waiting (job-queue)", pool_.backlog());
    if (*added == JobStore::Added::StoreFull)
        return busy(429, "waiting jobs take all the storage (job-bytes)", pool_.backlog());
    return {};
}

HttpResult<Job> JobService::find(const std::string& id, const std::string& owner) const {
    auto found = store_.find(id);
    if (!found) return store_problem(found.error());
    if (!*found || (*found)->owner != owner) return no_such_job();
    Job job = **std::move(found);
    runner_.add_latest(job);
    return job;
}

HttpResult<std::string> JobService::result(const std::string& id) {
    return existing(store_.result(id));
}

HttpResult<std::string> JobService::piece(const std::string& id, std::size_t number) {
    return existing(store_.piece(id, number));
}

HttpResult<void> JobService::remove(const std::string& id, const std::string& owner) {
    const auto found = find(id, owner);
    if (!found) return tl::unexpected(found.error());
    if (!is_finished(found->status)) {
        const auto cancelled = store_.cancel(id);
        if (!cancelled) return store_problem(cancelled.error());
        if (*cancelled) {
            stop(id);
            const Job& job = **cancelled;
            watched_.advance(job);
            logger_({job, {}, {}, {}});
            return {};
        }
    }
    if (auto removed = store_.remove(id); !removed) return store_problem(removed.error());
    return {};
}

void JobService::work() {
    runner_.claim();
}

void JobService::changed(const std::string& id) {
    watched_.mark_stale(id);
}

void JobService::stop(const std::string& id) {
    runner_.drop(id);
}

void JobService::missed() {
    watched_.mark_all_stale();
    runner_.refresh();
}

HttpResult<JobService::Watch> JobService::watch(const std::string& id, const std::string& owner) {
    const auto watched = watched_.watch(id);  // first, so that no notification is missed
    const auto job = find(id, owner);
    if (!job) return tl::unexpected(job.error());
    watched->advance(*job);
    return Watch(watched, [this](const std::string& job_id, WatchedJob& known) { look_again(job_id, known); });
}

/// Asks the store for the state of a job, which another server may run.
void JobService::look_again(const std::string& id, WatchedJob& watched) const {
    auto found = store_.find(id);
    if (!found) return;  // once the store can be reached again, missed() is called
    if (*found) {
        runner_.add_latest(**found);
        watched.advance(**found);
    } else {
        watched.mark_gone();
    }
}

std::optional<JobStore::Load> JobService::load() const {
    const auto load = store_.load();
    return load ? std::optional(*load) : std::nullopt;
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/job_limits.h"
#include "server/jobs/job_notifier.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_store.h"
#include "server/jobs/sqlite_job_tables.h"

namespace ccdt::server {

/// Jobs in a SQLite database, in a file or in memory.
///
/// A file has a write-ahead log and is synchronized at every commit, so that jobs survive a crash of the process or the
/// machine. Only one server at a time can use the file, so it keeps the claims in memory. When a file is opened,
/// unfinished jobs are queued in their original sequence. Damaged data is reported as an error (see SqliteJobTables).
/// A job is added only if the disk has space for its expected result and those of all unfinished jobs
/// (`Job::expected`). Jobs can be removed even when the disk is full. One thread at a time uses the database; others
/// wait while a request or a piece of a result is written.
class SqliteJobStore : public JobStore {
public:
    /// @param folder  folder of the database files, created if missing; empty: in memory
    /// Errors (Unusable): the folder cannot be used; another server uses it; the file belongs to another program or has
    /// another version of the tables; the file as a whole is damaged. Damage to single jobs only makes these jobs fail.
    /// The message names the folder or file.
    static Result<std::unique_ptr<SqliteJobStore>> open(const std::string& folder, const JobLimits& limits = {});

    Result<bool> is_full(std::string_view client) override;
    Result<Added> add(Job& job, const ComputeRequest& request) override;
    Result<std::optional<Job>> claim(std::size_t memory) override;
    Result<std::optional<ComputeRequest>> request(const std::string& id) override;
    Result<Renewal> renew(const Job& job) override;
    Result<void> requeue(const Job& job, bool counted) override;
    Result<bool> append_piece(const Job& job, const StoredPart& before, std::string_view piece) override;
    using JobStore::finish;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result, const StoredPart& before) override;
    Result<std::optional<Job>> cancel(const std::string& id) override;
    Result<std::optional<Webhook>> claim_webhook(std::chrono::milliseconds lease) override;
    Result<void> settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) override;
    Result<bool> remove_expired() override;
    Result<Load> load() override;
    void listen(JobListener* listener) override { notifier_.listen(listener); }
    std::uint64_t damages() const override { return damages_ + tables_.damages(); }

private:
    SqliteJobStore(const std::string& path, const JobLimits& limits);

    /// Runs a function with exclusive access to the tables and the queue.
    template <class Do>
    auto attempt(Do act) -> Result<decltype(act())>;

    template <class Do>
    auto run_freeing(Do act) -> Result<decltype(act())>;

    bool free_space(std::size_t bytes);
    std::optional<Job> begin(JobQueue::Entry entry);
    std::optional<SqliteJobTables::StoredJob> find_stored(const std::string& id);

    const JobLimits limits_;
    JobNotifier notifier_;
    std::atomic<std::uint64_t> damages_ = 0;
    std::mutex space_mutex_;  ///< held while space is freed and used; lock before `mutex_`

    std::mutex mutex_;  ///< guards the members below
    SqliteJobTables tables_;
    JobQueue queue_;
};

}  // namespace ccdt::server

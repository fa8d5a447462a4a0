// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/job_limits.h"
#include "server/jobs/job_notifier.h"
#include "server/jobs/job_store.h"
#include "server/jobs/sqlite.h"
#include "server/work/fair_queue.h"

namespace ccdt::server {

/// Jobs in a SQLite database, in a file or in memory.
///
/// A file has a write-ahead log and is synchronized at every commit, so that jobs survive a crash of the process or the
/// machine. Only one server at a time uses the file, and this server keeps the claims in memory. When a file is opened,
/// unfinished jobs are queued in their original order. All stored data has digests, which are checked when the data is
/// read: corruption by the disk is reported as an error, never returned as data. Some disk space is reserved in
/// advance, so that jobs can be removed when the disk is full. Free pages of the file are returned to the disk. One
/// thread at a time uses the database; other threads wait while a large request, or a piece of a result, is written.
class SqliteJobStore : public JobStore {
public:
    /// @param folder  folder of the database's files, created if it is missing; empty: in memory
    /// Errors (Unusable): the folder cannot be used; another server uses it; the file belongs to another program or has
    /// another version of the tables; the file is damaged beyond single jobs. Single damaged jobs are marked as failed
    /// instead. The message names the folder or file.
    static Result<std::unique_ptr<SqliteJobStore>> open(const std::string& folder, const JobLimits& limits = {});

    Result<bool> is_full(std::string_view client) override;
    Result<Added> add(Job& job, const ComputeRequest& request) override;
    Result<std::optional<Job>> claim(std::size_t memory) override;
    Result<std::optional<ComputeRequest>> request(const std::string& id) override;
    Result<Renewal> renew(const Job& job) override;
    Result<void> requeue(const Job& job) override;
    Result<bool> append_piece(const Job& job, const StoredPart& before, std::string_view piece) override;
    using JobStore::finish;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result, const StoredPart& before) override;
    Result<std::optional<Job>> cancel(const std::string& id) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) override;
    Result<bool> remove_expired() override;
    Result<Load> load() override;
    void listen(JobListener* listener) override { notifier_.listen(listener); }
    std::uint64_t damages() const override { return damages_; }

private:
    using Clock = std::chrono::steady_clock;

    /// A job that waits to be claimed.
    struct Waiting {
        std::string id;
        std::size_t memory = 0;
    };
    using Queue = FairQueue<Waiting>;

    /// A claimed job and its current state.
    struct Claimed {
        Queue::Entry entry;
        Job job;
        Clock::time_point until;
    };

    struct StoredJob;
    template <class T>
    struct Sealed;

    SqliteJobStore(const std::string& path, const JobLimits& limits);

    /// Runs a function with exclusive access to the database.
    template <class Do>
    auto attempt(Do act) -> Result<decltype(act())>;

    template <class Do>
    auto run_freeing(Do act) -> Result<decltype(act())>;

    void cut_log();
    void allocate_space(std::size_t bytes);
    void return_free_pages();

    void check_file();
    void create_tables();
    void fail_damaged();
    void fail_damaged(std::int64_t row);
    void seal(std::int64_t row);

    template <class Value>
    std::optional<StoredJob> look_up(const char* which, const Value& value);
    std::optional<StoredJob> look_up(const std::string& id);
    std::optional<Sealed<ComputeRequest>> request_of(const StoredJob& stored);
    std::optional<Sealed<std::string>> piece_of(const StoredJob& stored, std::size_t number);

    void queue_unfinished();
    bool accepts_job_of(std::string_view client) const;
    bool free_space(std::size_t bytes);
    bool drop_oldest_result();
    std::size_t remove_finished(Time by, std::size_t max_jobs);
    void insert(const Job& job, const ComputeRequest& request, std::size_t bytes);
    void take_back_lost();
    std::optional<Job> begin(Queue::Entry entry);
    Claimed* find_claimed(const Job& job);
    void withdraw(const std::string& id);
    void exchange(const Job& job, const StoredJob& stored, std::string_view result, const StoredPart& before);
    void insert_piece(const StoredJob& stored, std::size_t number, std::string_view piece);
    std::optional<StoredJob> find_stored(const std::string& id);

    void update(const Job& job, std::int64_t row, std::size_t bytes);
    void remove_question(std::int64_t row);
    std::size_t remove_pieces(std::int64_t row);
    void remove_bodies(std::int64_t row);
    std::size_t remove_row(std::int64_t row);
    void release(std::size_t bytes);

    const JobLimits limits_;
    JobNotifier notifier_;
    std::mutex space_mutex_;  ///< held while space is freed and used; locked before `mutex_`

    std::mutex mutex_;  ///< guards the members from here to `last_claim_`
    Database database_;
    Queue queue_;
    std::map<std::string, Claimed> claimed_;
    std::uint64_t last_claim_ = 0;

    std::atomic<std::size_t> bytes_ = 0;  ///< written while `mutex_` is held
    std::atomic<std::uint64_t> damages_ = 0;
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/job.h"
#include "server/jobs/job_store.h"
#include "server/jobs/sqlite.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// The tables of jobs, requests and results in a SQLite database.
///
/// All functions throw SqliteError. All stored data has digests, which are checked when the data is read; the error for
/// damaged data is SQLITE_CORRUPT. Each change is a transaction. The log has reserved disk space, so that jobs can be
/// removed when the disk is full. Not thread-safe, except for bytes() and damages().
class SqliteJobTables {
public:
    /// A stored job, the number of its row, and the bytes that it takes.
    struct StoredJob {
        Job job;
        std::int64_t row = 0;
        std::size_t bytes = 0;
    };

    /// Opens the database, or creates its tables. Rebuilds damaged indices, and marks jobs with damaged rows as failed.
    /// @param path  path of the file, or ":memory:"
    explicit SqliteJobTables(const std::string& path);

    /// Returns the bytes that all jobs together take.
    std::size_t bytes() const { return bytes_; }

    /// Returns the number of indices and jobs that were found damaged and repaired.
    std::uint64_t damages() const { return damages_; }

    /// Returns the unfinished jobs in the sequence in which they were added.
    std::vector<Job> unfinished();

    /// Finds a job; none if there is no such job.
    std::optional<StoredJob> find(const std::string& id);

    /// Reads a request; none if the job or its request does not exist.
    std::optional<ComputeRequest> request(const std::string& id);

    /// Reads a piece of a result; none if the job or the piece does not exist.
    std::optional<std::string> piece(const std::string& id, std::size_t number);

    /// Adds a job. Reserves disk space for it, and for the rest of the expected results of all unfinished jobs. Throws
    /// SQLITE_FULL if there is not enough.
    /// @param max_bytes  limit of bytes(); results above it replace older ones, and need no further space
    void insert(const Job& job, const ComputeRequest& request, std::size_t max_bytes);
    void update(const StoredJob& stored);
    void append(const StoredJob& stored, std::size_t number, std::string_view piece);

    /// Stores the state of a job before a new run, and deletes the pieces of its previous result.
    void restart(const StoredJob& stored);

    /// Stores the end of a job. Deletes its request, and stores the last part of its result, if there is one.
    /// @param job     state at the end
    /// @param stored  state before the end
    /// @param before  part of the result that is already stored
    void finish(const Job& job, const StoredJob& stored, std::string_view result,
                const JobStore::StoredPart& before = {});

    /// Claims a webhook that is due at the time `now`, as JobStore::claim_webhook() does, until the time `until`.
    std::optional<JobStore::Webhook> claim_webhook(Time now, Time until);

    /// Sets the time at which the webhook of a job is due; none: removes the webhook.
    void settle_webhook(const std::string& id, std::optional<Time> due);

    /// Removes a job; returns false if it does not exist.
    bool remove(const std::string& id);

    /// Removes up to `max_jobs` jobs that finished at the time `by` or earlier, starting with the job that finished
    /// first.
    /// @returns  number of removed jobs
    std::size_t remove_finished(Time by, std::size_t max_jobs);

    /// Deletes the result of the job that finished first.
    /// @returns  false if there is no result
    bool drop_oldest_result();

    /// Moves the contents of the write-ahead log to the database file, which has space for them, and truncates the log
    /// to its reserved size. Does nothing if the disk is full.
    void cut_log();

    /// Returns free pages of the file to the disk, up to 1,024 at a time.
    /// @returns  whether there may be more free pages
    bool return_free_pages();

private:
    void create();
    void fail_damaged_jobs();
    void fail_damaged_job(std::int64_t row);
    std::size_t promised(std::size_t more);
    void allocate_space(std::size_t bytes);
    void release(std::size_t bytes);

    Database database_;
    std::atomic<std::size_t> bytes_ = 0;
    std::atomic<std::uint64_t> damages_ = 0;
};

}  // namespace ccdt::server

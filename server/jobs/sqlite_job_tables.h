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
#include "server/work/compute_request.h"

namespace ccdt::server {

/// The tables of jobs, requests and results in a SQLite database.
///
/// All functions throw SqliteError. All stored data has digests, which are checked when the data is read: for damaged
/// data, the error is SQLITE_CORRUPT. Each change is a transaction. Some disk space is reserved in advance, so that
/// jobs can be removed when the disk is full. Not thread-safe, except for bytes() and damages().
class SqliteJobTables {
public:
    /// A stored job, its row, and the bytes that it takes.
    struct StoredJob {
        Job job;
        std::int64_t row = 0;
        std::size_t bytes = 0;
    };

    /// Opens the database, or creates its tables. Damaged indices are rebuilt, and jobs whose rows are damaged fail.
    /// @param path  of the file, or ":memory:"
    explicit SqliteJobTables(const std::string& path);

    /// Bytes that all jobs take.
    std::size_t bytes() const { return bytes_; }

    /// Number of indices and jobs that were found damaged and repaired.
    std::uint64_t damages() const { return damages_; }

    /// Returns the unfinished jobs in their original order.
    std::vector<Job> unfinished();

    /// @returns  none if there is no such job
    std::optional<StoredJob> find(const std::string& id);

    /// @returns  none if the job or its request does not exist
    std::optional<ComputeRequest> request(const std::string& id);

    /// @returns  none if the job or its result does not exist
    std::optional<std::string> piece(const std::string& id, std::size_t number);

    void insert(const Job& job, const ComputeRequest& request);
    void update(const StoredJob& stored);
    void append(const StoredJob& stored, std::size_t number, std::string_view piece);

    /// Stores the state of a job that starts again, and deletes the pieces of its result.
    void restart(const StoredJob& stored);

    /// Stores the end of a job: replaces its request by its result, if there is one.
    /// @param job     state at the end
    /// @param stored  state before the end
    /// @param before  part of the result that is stored already
    void finish(const Job& job, const StoredJob& stored, std::string_view result,
                const JobStore::StoredPart& before = {});

    /// @returns  false if there is no such job
    bool remove(const std::string& id);

    /// Removes some of the jobs that had finished by `by`, oldest first.
    /// @returns  number of removed jobs
    std::size_t remove_finished(Time by, std::size_t max_jobs);

    /// Drops the result of the job that finished first.
    /// @returns  false if there is none
    bool drop_oldest_result();

    /// Moves the contents of the log to the database file, where space is allocated, and truncates the log to its
    /// reserved size. Fails without an exception if the disk is full.
    void cut_log();

    /// Returns some free pages of the file to the disk.
    /// @returns  whether there may be more
    bool return_free_pages();

private:
    void create();
    void fail_damaged_jobs();
    void fail_damaged_job(std::int64_t row);
    void allocate_space(std::size_t bytes);
    void release(std::size_t bytes);

    Database database_;
    std::atomic<std::size_t> bytes_ = 0;
    std::atomic<std::uint64_t> damages_ = 0;
};

}  // namespace ccdt::server

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/job_store.h"
#include "server/jobs/sqlite.h"

namespace ccdt::server {

/// Jobs in a SQLite database, in a file or in memory.
///
/// A file is written ahead (WAL) and synchronised with every commit, so that jobs survive the process and the machine.
/// It belongs to one server at a time. All that is kept has a digest, with which it is compared when it is read: what
/// the disk has changed is told, and never taken for what was written. The file has a reserve of the disk, so that jobs
/// can be removed when the disk is full, and gives back what it does not need. One thread uses the database, the others
/// wait: as long as a large result takes to be written.
class SqliteJobStore : public JobStore {
public:
    /// @param folder  where the database's files are, made if it is missing; empty: in memory
    /// Errors (Unusable): the folder cannot be used, another server uses it, the file is damaged beyond single
    /// jobs, something else's or of a later version of this program. The message names it. Files of earlier versions
    /// are taken over; jobs that are damaged fail.
    static Result<std::unique_ptr<SqliteJobStore>> open(const std::string& folder);

    Result<void> add(const Job& job, const ComputeRequest& request) override;
    Result<std::vector<Job>> unfinished() override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<ComputeRequest>> request(const std::string& id) override;
    Result<std::optional<std::string>> result(const std::string& id) override;
    Result<void> save(const Job& job) override;
    Result<void> finish(const Job& job, std::string_view result) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::size_t> remove_finished(Time by, std::size_t most) override;
    Result<std::optional<Time>> first_finished() override;
    Result<bool> drop_oldest_result() override;
    std::size_t bytes() const override { return bytes_; }

    /// Times that something was not as it had been written.
    std::uint64_t damages() const { return damages_; }

private:
    struct Kept;
    template <class T>
    struct Sealed;

    explicit SqliteJobStore(const std::string& path);

    /// Does something with the database that no other thread uses meanwhile.
    template <class Do>
    auto attempt(Do act) -> Result<decltype(act())>;

    template <class Do>
    auto free_room(Do act) -> Result<decltype(act())>;

    void cut_log();
    void take_room(std::size_t bytes);
    void give_back();

    void check_file();
    void prepare_tables(std::int64_t version);
    void fail_damaged();
    void fail_damaged(std::int64_t row);
    template <class Test>
    std::vector<std::int64_t> rows_where(Test test);
    void seal(std::int64_t row);

    template <class Value>
    std::optional<Kept> look_up(const char* which, const Value& value);
    std::optional<Kept> look_up(const std::string& id);
    std::optional<Sealed<ComputeRequest>> request_of(const Kept& kept);
    std::optional<Sealed<std::string>> result_of(const Kept& kept);

    void update(const Job& job, std::int64_t row, std::size_t bytes);
    void remove_bodies(std::int64_t row);
    std::size_t remove_row(std::int64_t row);
    void release(std::size_t bytes);

    std::mutex mutex_;  ///< guards the database
    Database database_;
    std::atomic<std::size_t> bytes_ = 0;  ///< written under the mutex
    std::atomic<std::uint64_t> damages_ = 0;
};

}  // namespace ccdt::server

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/jobs/job_store.h"
#include "server/jobs/sqlite.h"

namespace ccdt::server {

/// Jobs in a SQLite database, in a file or in memory.
///
/// A file is written ahead (WAL) and synchronised with every commit, so that jobs survive the process and the machine.
/// It belongs to one server at a time. One thread uses the database, the others wait: as long as a large result takes
/// to be written.
class SqliteJobStore : public JobStore {
public:
    /// @param folder  where the database's files are, made if it is missing; empty: in memory
    /// Errors (Unusable): the folder cannot be used, another server uses it, the file is damaged, something else's or
    /// of another version of this program. The message names it.
    static Result<std::unique_ptr<SqliteJobStore>> open(const std::string& folder);

    Result<void> add(const Job& job, const Question& question) override;
    Result<std::vector<Job>> unfinished() override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<Question>> question(const std::string& id) override;
    Result<std::optional<std::string>> result(const std::string& id) override;
    Result<void> save(const Job& job) override;
    Result<void> finish(const Job& job, std::string_view result) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::size_t> remove_finished(Time by, std::size_t most) override;
    Result<std::optional<Time>> first_finished() override;
    Result<bool> drop_oldest_result() override;
    std::size_t bytes() const override { return bytes_; }

private:
    explicit SqliteJobStore(const std::string& path);

    /// Does something with the database that no other thread uses meanwhile.
    template <class Do>
    auto attempt(Do act) -> Result<decltype(act())>;

    void prepare_tables();
    void update(const Job& job, std::optional<std::size_t> bytes);
    std::size_t remove_row(std::int64_t row);

    std::mutex mutex_;  ///< guards the database
    Database database_;
    std::atomic<std::size_t> bytes_ = 0;  ///< written under the mutex
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sqlite_job_store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "tests/server/jobs/example_jobs.h"

namespace ccdt::server {
namespace {

using test::add;
using test::add_finished;
using test::job_named;
using test::kComputeRequest;
using test::succeeded;

/// Number of instructions that SQLite has executed in all databases opened after `install_counter` was registered.
std::size_t instructions = 0;

int install_counter(sqlite3* database, const char**, const void*) {
    const auto count = [](void*) {
        ++instructions;
        return 0;
    };
    sqlite3_progress_handler(database, 1, count, nullptr);
    return SQLITE_OK;
}

/// Limits the size of files, as a small disk would.
class SmallFiles {
public:
    explicit SmallFiles(rlim_t bytes) {
        EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
        const rlimit small{bytes, before_.rlim_max};
        EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    }
    ~SmallFiles() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }

    SmallFiles(const SmallFiles&) = delete;
    SmallFiles& operator=(const SmallFiles&) = delete;

private:
    void (*const handler_)(int) = std::signal(SIGXFSZ, SIG_IGN);
    rlimit before_{};
};

class SqliteJobStoreTest : public testing::Test {
protected:
    SqliteJobStoreTest() : folder_(std::filesystem::path(testing::TempDir()) / "jobs-XXXXXX") {
        std::string name = folder_.string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    ~SqliteJobStoreTest() override { std::filesystem::remove_all(folder_); }

    std::unique_ptr<SqliteJobStore> open(const JobLimits& limits = {}) {
        auto store = SqliteJobStore::open(folder_.string(), limits);
        if (store) return *std::move(store);
        ADD_FAILURE() << store.error().message;
        return nullptr;
    }

    std::string why_not() {
        const auto store = SqliteJobStore::open(folder_.string());
        return store ? "" : store.error().message;
    }

    std::string file() const { return (folder_ / "jobs.sqlite").string(); }

    std::filesystem::path folder_;
};

TEST_F(SqliteJobStoreTest, CostsNoMoreWithManyJobs) {
    ASSERT_EQ(sqlite3_auto_extension(reinterpret_cast<void (*)()>(install_counter)), SQLITE_OK);
    const auto store = *SqliteJobStore::open("", {.bytes = std::numeric_limits<std::size_t>::max()});
    sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(install_counter));
    int added = 0;
    const auto grow_to = [&](int count) {
        for (; added < count; ++added) add_finished(*store, "old-" + std::to_string(added), "result");
    };
    const auto work = [&](const std::string& id) {
        instructions = 0;
        add_finished(*store, id, "result");
        EXPECT_TRUE(*store->find(id));
        EXPECT_TRUE(*store->result(id));
        EXPECT_FALSE(*store->remove_expired());
        EXPECT_TRUE(*store->remove(id));
        EXPECT_EQ(*store->claim(1000), std::nullopt);
        return instructions;
    };
    grow_to(10);
    const auto few = work("few");
    EXPECT_GT(few, 100u);
    grow_to(10'000);
    EXPECT_LE(work("many"), few + few / 10);
}

TEST_F(SqliteJobStoreTest, BelongsToOneServer) {
    const auto store = open();
    EXPECT_NE(why_not().find("another server uses it"), std::string::npos) << why_not();
}

TEST_F(SqliteJobStoreTest, RefusesFilesOfOtherPrograms) {
    std::ofstream(file()) << std::string(5000, 'x');
    EXPECT_NE(why_not().find("not a database"), std::string::npos) << why_not();
    std::filesystem::remove(file());
    Database(file()).execute("CREATE TABLE theirs (a); PRAGMA application_id = 7");
    EXPECT_NE(why_not().find("another program"), std::string::npos) << why_not();
    EXPECT_EQ(Database(file()).value_of("PRAGMA application_id"), 7);
}

TEST_F(SqliteJobStoreTest, RefusesFilesOfUnknownVersions) {
    open();
    Database(file()).execute("PRAGMA user_version = 99");
    EXPECT_NE(why_not().find("version 99"), std::string::npos) << why_not();
}

TEST_F(SqliteJobStoreTest, RefusesDamagedFiles) {
    {
        const auto store = open();
        for (int i = 0; i < 100; ++i) add(*store, job_named(std::to_string(i)));
    }
    std::fstream damaged(file(), std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(4096);
    damaged << std::string(16'384, 'x');
    damaged.close();
    EXPECT_NE(why_not(), "");
}

TEST_F(SqliteJobStoreTest, RefusesJobsWhoseResultsDoNotFit) {
    constexpr std::size_t kBytes = 300'000;
    const SmallFiles small(rlim_t{24} << 20);
    auto store = open();
    const auto add_one = [&](int i) {
        Job job = job_named(std::to_string(i));
        job.expected = kBytes;
        return store->add(job, kComputeRequest);
    };
    int added = 0;
    while (added < 1000 && add_one(added) == JobStore::Added::Accepted) ++added;
    EXPECT_GT(added, 50);
    EXPECT_LT(added, 84);
    const auto expect_full = [&] {
        const auto refused = add_one(added);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::LimitExceeded);
    };
    expect_full();
    store.reset();
    store = open();
    expect_full();
    for (int i = 0; i < 2; ++i) EXPECT_TRUE(*store->cancel(std::to_string(i)));
    EXPECT_EQ(add_one(added), JobStore::Added::Accepted);
    int finished = 0;
    while (const auto job = *store->claim(1000)) {
        const std::string result(kBytes, 'r');
        const auto ended = store->finish(succeeded(*job, result), result);
        EXPECT_TRUE(ended && *ended) << job->id;
        ++finished;
    }
    EXPECT_EQ(finished, added - 1);
}

TEST_F(SqliteJobStoreTest, DetectsCorruptResults) {
    add_finished(*open(), "a", "result");
    Database(file()).execute("UPDATE results SET body = CAST('resulT' AS BLOB)");
    const auto store = open();
    const auto result = store->result("a");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_EQ(store->damages(), 1u);
    EXPECT_TRUE(*store->remove("a"));
    EXPECT_EQ(store->load()->bytes, 0u);
}

TEST_F(SqliteJobStoreTest, DetectsReorderedPieces) {
    {
        const auto store = open();
        add(*store, job_named("a"));
        const Job job = **store->claim(1000);
        ASSERT_TRUE(*store->append_piece(job, {}, "one"));
        ASSERT_TRUE(*store->finish(succeeded(job, "onetwo"), "two", {1, 3}));
    }
    Database(file()).execute("UPDATE results SET number = number + 5; UPDATE results SET number = 6 - number");
    const auto store = open();
    for (const std::size_t number : {0, 1}) EXPECT_EQ(store->piece("a", number).error().code, ErrorCode::Unusable);
}

TEST_F(SqliteJobStoreTest, DetectsALostResult) {
    add_finished(*open(), "a", "result");
    Database(file()).execute("DELETE FROM results");
    EXPECT_EQ(open()->result("a").error().code, ErrorCode::Unusable);
}

TEST_F(SqliteJobStoreTest, DetectsSwappedResults) {
    {
        const auto store = open();
        add_finished(*store, "a", "this");
        add_finished(*store, "b", "that");
    }
    Database(file()).execute("UPDATE results SET job = job + 10; UPDATE results SET job = 13 - job");
    const auto store = open();
    EXPECT_FALSE(store->result("a"));
    EXPECT_FALSE(store->result("b"));
}

TEST_F(SqliteJobStoreTest, DetectsCorruptRequests) {
    for (const char* change : {"path = '/halftone'", "query = 'a=c'", "content_type = ''", "accept = ''",
                               "body = CAST('a body' AS BLOB)", "path = '/samplea', query = '=b'"}) {
        add(*open(), job_named(change));
        Database(file()).execute(("UPDATE questions SET " + std::string(change)).c_str());
        const auto store = open();
        const auto request = store->request(change);
        ASSERT_FALSE(request) << change;
        EXPECT_EQ(request.error().code, ErrorCode::Unusable);
        EXPECT_TRUE(*store->remove(change));
    }
}

TEST_F(SqliteJobStoreTest, DropsCorruptWebhooks) {
    Job job = job_named("a");
    job.callback = "https://example.org";
    add(*open(), job);
    ASSERT_TRUE(*open()->cancel("a"));
    Database(file()).execute("UPDATE webhooks SET url = 'https://example.com'");
    EXPECT_EQ(*open()->claim_webhook({}), std::nullopt);
    EXPECT_EQ(Database(file()).value_of("SELECT count(*) FROM webhooks"), 0);
}

TEST_F(SqliteJobStoreTest, AddsTheTableOfWebhooks) {
    add_finished(*open(), "a", "result");
    Database(file()).execute("DROP TABLE webhooks");
    EXPECT_EQ(open()->result("a"), "result");
    EXPECT_EQ(*open()->claim_webhook({}), std::nullopt);
}

TEST_F(SqliteJobStoreTest, FailsCorruptJobs) {
    for (const char* change :
         {"owner = 'bob'",    "client = 'b'",  "memory = 1",    "seconds = 0",  "status = 1",
          "starts = 7",       "created = 1",   "started = 1",   "fraction = 1", "iteration = 1",
          "variation = 1",    "failure = 400", "message = 'm'", "field = 'f'",  "media_type = 'text/html'",
          "result_bytes = 7", "partial = 1",   "dropped = 1",   "bytes = 1",    "traceparent = ''",
          "digest = ''"}) {
        add_finished(*open(), change, "result");
        Database(file()).execute(("UPDATE jobs SET " + std::string(change)).c_str());
        const auto store = open();
        const auto job = store->find(change);
        ASSERT_TRUE(job && *job) << change;
        EXPECT_EQ((*job)->status, JobStatus::Failed) << change;
        ASSERT_TRUE((*job)->failure);
        EXPECT_EQ((*job)->failure->status, 500);
        EXPECT_EQ(*store->result(change), std::nullopt);
        EXPECT_EQ(store->damages(), 1u);
        EXPECT_EQ(store->load()->bytes, JobStore::bytes_of_job(0));
        EXPECT_TRUE(*store->remove(change));
    }
}

TEST_F(SqliteJobStoreTest, FailsCorruptWaitingJobs) {
    add(*open(), job_named("a"));
    Database(file()).execute("UPDATE jobs SET memory = 1");
    const auto store = open();
    EXPECT_EQ(*store->claim(1000), std::nullopt);
    EXPECT_EQ((*store->find("a"))->status, JobStatus::Failed);
}

TEST_F(SqliteJobStoreTest, RebuildsInconsistentIndices) {
    {
        const auto store = open();
        add_finished(*store, "gone", "result");
        add_finished(*store, "there", "result");
    }
    const auto root = Database(file()).value_of("SELECT rootpage FROM sqlite_schema WHERE name = 'finished_jobs'");
    Database(file()).execute("PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name = 'finished_jobs'");
    Database(file()).execute("DELETE FROM jobs WHERE id = 'gone'");
    Database(file()).execute(
        ("PRAGMA writable_schema = ON; INSERT INTO sqlite_schema VALUES ('index', 'finished_jobs', "
         "'jobs', " +
         std::to_string(root) + ", 'CREATE INDEX finished_jobs ON jobs (finished) WHERE finished IS NOT NULL')")
            .c_str());
    {
        const auto store = open();
        EXPECT_EQ(store->damages(), 1u);
        EXPECT_EQ(**store->result("there"), "result");
    }
    const auto store = open({.ttl = std::chrono::milliseconds(0)});
    EXPECT_FALSE(*store->remove_expired());
    EXPECT_EQ(store->load()->bytes, 0u);
}

TEST_F(SqliteJobStoreTest, ReturnsFreeSpaceToTheDisk) {
    const std::string large(std::size_t{20} << 20, 'x');
    const auto size = [this] { return std::filesystem::file_size(file()); };
    const auto log = [this] { return std::filesystem::file_size(file() + "-wal"); };
    const auto store = open();
    const auto reserve = log();
    EXPECT_GE(reserve, std::size_t{1} << 20);
    for (const char* id : {"a", "b", "c"}) add_finished(*store, id, large);
    EXPECT_EQ(log(), reserve);
    EXPECT_GT(size(), 3 * large.size());
    EXPECT_TRUE(*store->remove("a"));
    EXPECT_LT(size(), 5 * large.size() / 2);
    EXPECT_TRUE(*store->remove("b"));
    EXPECT_TRUE(*store->remove("c"));
    EXPECT_LT(size(), large.size() / 2);
    EXPECT_EQ(log(), reserve);
}

TEST_F(SqliteJobStoreTest, NamesAnUnusableFolder) {
    std::ofstream(folder_ / "file") << "x";
    const auto store = SqliteJobStore::open((folder_ / "file" / "below").string());
    ASSERT_FALSE(store);
    EXPECT_NE(store.error().message.find("below"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::server

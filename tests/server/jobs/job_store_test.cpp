#include "server/jobs/job_store.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "server/jobs/sqlite_job_store.h"

namespace ccdt::server {
namespace {

/// Instructions that SQLite has carried out, in all databases opened since `count_instructions`.
std::size_t instructions = 0;

int install_counter(sqlite3* database, const char**, const void*) {
    const auto count = [](void*) {
        ++instructions;
        return 0;
    };
    sqlite3_progress_handler(database, 1, count, nullptr);
    return SQLITE_OK;
}

const Question kQuestion{"/sample", "a=b", "text/plain", "*/*", std::string("a body\0with all bytes\xff", 23)};

Job job_named(const std::string& id) {
    Job job;
    job.id = id;
    job.owner = "alice";
    job.client = "key alice";
    job.cost = {1000, 0.5};
    job.created = time_now();
    return job;
}

class JobStoreTest : public testing::Test {
protected:
    JobStoreTest() : folder_(std::filesystem::path(testing::TempDir()) / "jobs-XXXXXX") {
        std::string name = folder_.string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    ~JobStoreTest() override { std::filesystem::remove_all(folder_); }

    std::unique_ptr<SqliteJobStore> open() {
        auto store = SqliteJobStore::open(folder_.string());
        if (store) return *std::move(store);
        ADD_FAILURE() << store.error().message;
        return nullptr;
    }

    std::string why_not() {
        const auto store = SqliteJobStore::open(folder_.string());
        return store ? "" : store.error().message;
    }

    std::string file() const { return (folder_ / "jobs.sqlite").string(); }

    /// Adds a job and finishes it.
    static void add_finished(JobStore& store, const std::string& id, Time finished, const std::string& result) {
        Job job = job_named(id);
        ASSERT_TRUE(store.add(job, kQuestion));
        job.status = JobStatus::Succeeded;
        job.finished = finished;
        job.media_type = "text/plain";
        job.result_bytes = result.size();
        ASSERT_TRUE(store.finish(job, result));
    }

    std::filesystem::path folder_;
};

TEST_F(JobStoreTest, KeepsJobsAndQuestionsWhenItIsOpenedAgain) {
    Job job = job_named("a");
    {
        const auto store = open();
        ASSERT_TRUE(store->add(job, kQuestion));
        ASSERT_TRUE(store->add(job_named("b"), kQuestion));
        job.status = JobStatus::Running;
        job.starts = 2;
        job.started = time_now();
        ASSERT_TRUE(store->save(job));
    }
    const auto store = open();
    const auto unfinished = store->unfinished();
    ASSERT_TRUE(unfinished);
    ASSERT_EQ(unfinished->size(), 2u);
    const Job& found = unfinished->front();
    EXPECT_EQ(found.id, "a");
    EXPECT_EQ(found.owner, job.owner);
    EXPECT_EQ(found.client, job.client);
    EXPECT_EQ(found.cost.memory, job.cost.memory);
    EXPECT_EQ(found.cost.seconds, job.cost.seconds);
    EXPECT_EQ(found.status, JobStatus::Running);
    EXPECT_EQ(found.starts, 2);
    EXPECT_EQ(found.created, job.created);
    EXPECT_EQ(found.started, job.started);
    EXPECT_EQ(found.finished, std::nullopt);
    const auto question = store->question("a");
    ASSERT_TRUE(question && *question);
    EXPECT_EQ((*question)->path, kQuestion.path);
    EXPECT_EQ((*question)->query, kQuestion.query);
    EXPECT_EQ((*question)->content_type, kQuestion.content_type);
    EXPECT_EQ((*question)->accept, kQuestion.accept);
    EXPECT_EQ((*question)->body, kQuestion.body);
    EXPECT_EQ(store->bytes(), 2 * JobStore::bytes_of_job(kQuestion.path.size() + kQuestion.query.size() +
                                                         kQuestion.content_type.size() + kQuestion.accept.size() +
                                                         kQuestion.body.size()));
}

TEST_F(JobStoreTest, ExchangesTheQuestionForTheResult) {
    const auto store = open();
    const std::string result(
        "\0\xff"
        "bytes",
        7);
    add_finished(*store, "a", time_now(), result);
    EXPECT_EQ(*store->question("a"), std::nullopt);
    EXPECT_EQ(**store->result("a"), result);
    EXPECT_EQ((*store->find("a"))->result_bytes, result.size());
    EXPECT_EQ((*store->find("a"))->media_type, "text/plain");
    EXPECT_EQ(store->bytes(), JobStore::bytes_of_job(result.size()));
    EXPECT_TRUE(store->unfinished()->empty());
    EXPECT_TRUE(*store->remove("a"));
    EXPECT_FALSE(*store->remove("a"));
    EXPECT_EQ(*store->find("a"), std::nullopt);
    EXPECT_EQ(*store->result("a"), std::nullopt);
    EXPECT_EQ(store->bytes(), 0u);
}

TEST_F(JobStoreTest, KeepsFailures) {
    const auto store = open();
    Job job = job_named("a");
    ASSERT_TRUE(store->add(job, kQuestion));
    job.status = JobStatus::Failed;
    job.finished = time_now();
    job.progress = {0.5, 3, 0.25};
    job.failure = JobFailure{422, {ErrorCode::Unusable, "crossing", "/polygon/2"}};
    ASSERT_TRUE(store->finish(job, {}));
    const Job found = **store->find("a");
    EXPECT_EQ(found.status, JobStatus::Failed);
    EXPECT_EQ(found.progress.fraction, 0.5);
    EXPECT_EQ(found.progress.iteration, 3);
    EXPECT_EQ(found.progress.variation, 0.25);
    ASSERT_TRUE(found.failure);
    EXPECT_EQ(found.failure->status, 422);
    EXPECT_EQ(found.failure->error.message, "crossing");
    EXPECT_EQ(found.failure->error.field, "/polygon/2");
}

TEST_F(JobStoreTest, RemovesAndDropsTheOldestFirst) {
    const auto store = open();
    const Time now = time_now();
    const std::chrono::milliseconds second(1000);
    add_finished(*store, "newest", now, "result");
    add_finished(*store, "oldest", now - 3 * second, "result");
    add_finished(*store, "older", now - 2 * second, "result");
    ASSERT_TRUE(store->add(job_named("waits"), kQuestion));
    EXPECT_EQ(*store->first_finished(), now - 3 * second);

    EXPECT_TRUE(*store->drop_oldest_result());
    EXPECT_TRUE((*store->find("oldest"))->dropped);
    EXPECT_EQ(*store->result("oldest"), std::nullopt);
    EXPECT_FALSE((*store->find("older"))->dropped);

    EXPECT_EQ(*store->remove_finished(now - second, 1), 1u);
    EXPECT_EQ(*store->find("oldest"), std::nullopt);
    EXPECT_EQ(*store->remove_finished(now - second, 5), 1u);
    EXPECT_EQ(*store->first_finished(), now);
    EXPECT_TRUE(*store->drop_oldest_result());
    EXPECT_FALSE(*store->drop_oldest_result());
    EXPECT_EQ(*store->remove_finished(now, 5), 1u);
    EXPECT_EQ(*store->first_finished(), std::nullopt);
    EXPECT_TRUE(*store->find("waits"));
}

TEST_F(JobStoreTest, DoesNoMoreForHavingManyJobs) {
    ASSERT_EQ(sqlite3_auto_extension(reinterpret_cast<void (*)()>(install_counter)), SQLITE_OK);
    const auto store = *SqliteJobStore::open("");
    sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(install_counter));
    const Time start = time_now();
    int added = 0;
    const auto grow_to = [&](int count) {
        for (; added < count; ++added)
            add_finished(*store, "old-" + std::to_string(added), start - std::chrono::milliseconds(added), "result");
    };
    const auto work = [&](const std::string& id) {
        instructions = 0;
        add_finished(*store, id, start, "result");
        EXPECT_TRUE(*store->find(id));
        EXPECT_TRUE(*store->result(id));
        EXPECT_TRUE(*store->first_finished());
        EXPECT_TRUE(*store->drop_oldest_result());
        EXPECT_EQ(*store->remove_finished(start, 1), 1u);
        EXPECT_TRUE(*store->remove(id));
        EXPECT_TRUE(store->unfinished()->empty());
        return instructions;
    };
    grow_to(10);
    const auto few = work("few");
    EXPECT_GT(few, 100u);
    grow_to(10'000);
    EXPECT_LE(work("many"), few + few / 10);
}

TEST_F(JobStoreTest, BelongsToOneServer) {
    const auto store = open();
    EXPECT_NE(why_not().find("another server uses it"), std::string::npos) << why_not();
}

TEST_F(JobStoreTest, TakesNothingElsesFile) {
    std::ofstream(file()) << std::string(5000, 'x');
    EXPECT_NE(why_not().find("not a database"), std::string::npos) << why_not();
    std::filesystem::remove(file());
    Database(file()).execute("CREATE TABLE theirs (a); PRAGMA application_id = 7");
    EXPECT_NE(why_not().find("another program"), std::string::npos) << why_not();
    EXPECT_EQ(Database(file()).value_of("PRAGMA application_id"), 7);
}

TEST_F(JobStoreTest, TakesNoOtherVersionsFile) {
    open();
    Database(file()).execute("PRAGMA user_version = 99");
    EXPECT_NE(why_not().find("version 99"), std::string::npos) << why_not();
}

TEST_F(JobStoreTest, TakesNoDamagedFile) {
    {
        const auto store = open();
        for (int i = 0; i < 100; ++i) ASSERT_TRUE(store->add(job_named(std::to_string(i)), kQuestion));
    }
    std::fstream damaged(file(), std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(4096);
    damaged << std::string(16'384, 'x');
    damaged.close();
    EXPECT_NE(why_not(), "");
}

TEST_F(JobStoreTest, NamesAFolderThatCannotBeUsed) {
    std::ofstream(folder_ / "file") << "x";
    const auto store = SqliteJobStore::open((folder_ / "file" / "below").string());
    ASSERT_FALSE(store);
    EXPECT_NE(store.error().message.find("below"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::server

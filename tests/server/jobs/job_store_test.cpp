#include "server/jobs/job_store.h"

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/jobs/sqlite_job_store.h"
#include "tests/server/jobs/example_jobs.h"

namespace ccdt::server {
namespace {

using test::add_finished;
using test::job_named;
using test::kComputeRequest;

/// Where a test keeps jobs: empty at first, gone at its end.
class Place {
public:
    virtual ~Place() = default;

    /// Opens a store there; no other is open. Null if that fails.
    virtual std::unique_ptr<JobStore> open() = 0;
};

class Memory : public Place {
public:
    std::unique_ptr<JobStore> open() override { return SqliteJobStore::open("").value_or(nullptr); }
};

class Folder : public Place {
public:
    Folder() : path_(std::filesystem::path(testing::TempDir()) / "any-jobs-XXXXXX") {
        std::string name = path_.string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        path_ = name;
    }
    ~Folder() override { std::filesystem::remove_all(path_); }

    std::unique_ptr<JobStore> open() override { return SqliteJobStore::open(path_.string()).value_or(nullptr); }

private:
    std::filesystem::path path_;
};

/// A kind of store that has to keep what JobStore promises: another one is another row.
struct Kind {
    const char* name;
    bool outlives_its_server;
    std::unique_ptr<Place> (*make)();
};

const Kind kKinds[] = {
    {"SqliteInMemory", false, [] { return std::unique_ptr<Place>(std::make_unique<Memory>()); }},
    {"SqliteInAFolder", true, [] { return std::unique_ptr<Place>(std::make_unique<Folder>()); }},
};

class JobStoreTest : public testing::TestWithParam<Kind> {
protected:
    void SetUp() override { open_again(); }

    /// Opens another store where the last one was, which is closed.
    void open_again() {
        store_.reset();
        store_ = place_->open();
        ASSERT_NE(store_, nullptr);
    }

    const std::unique_ptr<Place> place_ = GetParam().make();
    std::unique_ptr<JobStore> store_;
};

INSTANTIATE_TEST_SUITE_P(Any, JobStoreTest, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return kind.param.name; });

void expect_equal(const Job& found, const Job& job) {
    EXPECT_EQ(found.id, job.id);
    EXPECT_EQ(found.owner, job.owner);
    EXPECT_EQ(found.client, job.client);
    EXPECT_EQ(found.cost.memory, job.cost.memory);
    EXPECT_EQ(found.cost.seconds, job.cost.seconds);
    EXPECT_EQ(found.status, job.status);
    EXPECT_EQ(found.starts, job.starts);
    EXPECT_EQ(found.created, job.created);
    EXPECT_EQ(found.started, job.started);
    EXPECT_EQ(found.finished, job.finished);
}

TEST_P(JobStoreTest, KeepsJobsAndQuestionsAsTheyAre) {
    Job job = job_named("a");
    ASSERT_TRUE(store_->add(job, kComputeRequest));
    ASSERT_TRUE(store_->add(job_named("b"), kComputeRequest));
    job.status = JobStatus::Running;
    job.starts = 2;
    job.started = time_now();
    ASSERT_TRUE(store_->save(job));
    if (GetParam().outlives_its_server) open_again();

    const auto unfinished = store_->unfinished();
    ASSERT_TRUE(unfinished);
    ASSERT_EQ(unfinished->size(), 2u);
    expect_equal(unfinished->front(), job);
    expect_equal(**store_->find("a"), job);
    EXPECT_EQ(unfinished->back().id, "b");
    const auto request = store_->request("a");
    ASSERT_TRUE(request && *request);
    EXPECT_EQ((*request)->path, kComputeRequest.path);
    EXPECT_EQ((*request)->query, kComputeRequest.query);
    EXPECT_EQ((*request)->content_type, kComputeRequest.content_type);
    EXPECT_EQ((*request)->accept, kComputeRequest.accept);
    EXPECT_EQ((*request)->body, kComputeRequest.body);
    EXPECT_EQ(store_->bytes(), 2 * JobStore::bytes_of_job(kComputeRequest.path.size() + kComputeRequest.query.size() +
                                                          kComputeRequest.content_type.size() +
                                                          kComputeRequest.accept.size() + kComputeRequest.body.size()));
}

TEST_P(JobStoreTest, KnowsNothingOfOtherJobs) {
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(*store_->request("a"), std::nullopt);
    EXPECT_EQ(*store_->result("a"), std::nullopt);
    EXPECT_TRUE(store_->save(job_named("a")));
    EXPECT_TRUE(store_->finish(job_named("a"), "result"));
    EXPECT_FALSE(*store_->remove("a"));
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(store_->bytes(), 0u);
}

TEST_P(JobStoreTest, ExchangesTheQuestionForTheResult) {
    const std::string result(
        "\0\xff"
        "bytes",
        7);
    add_finished(*store_, "a", time_now(), result);
    EXPECT_EQ(*store_->request("a"), std::nullopt);
    EXPECT_EQ(**store_->result("a"), result);
    EXPECT_EQ((*store_->find("a"))->result_bytes, result.size());
    EXPECT_EQ((*store_->find("a"))->media_type, "text/plain");
    EXPECT_EQ(store_->bytes(), JobStore::bytes_of_job(result.size()));
    EXPECT_TRUE(store_->unfinished()->empty());
    EXPECT_TRUE(*store_->remove("a"));
    EXPECT_FALSE(*store_->remove("a"));
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(*store_->result("a"), std::nullopt);
    EXPECT_EQ(store_->bytes(), 0u);
}

TEST_P(JobStoreTest, KeepsFailures) {
    Job job = job_named("a");
    ASSERT_TRUE(store_->add(job, kComputeRequest));
    job.status = JobStatus::Failed;
    job.finished = time_now();
    job.progress = {0.5, 3, 0.25};
    job.failure = Problem{422, {ErrorCode::Unusable, "crossing", "/polygon/2"}};
    ASSERT_TRUE(store_->finish(job, {}));
    const Job found = **store_->find("a");
    EXPECT_EQ(found.status, JobStatus::Failed);
    EXPECT_EQ(found.progress.fraction, 0.5);
    EXPECT_EQ(found.progress.iteration, 3);
    EXPECT_EQ(found.progress.variation, 0.25);
    ASSERT_TRUE(found.failure);
    EXPECT_EQ(found.failure->status, 422);
    EXPECT_EQ(found.failure->error.message, "crossing");
    EXPECT_EQ(found.failure->error.field, "/polygon/2");
}

TEST_P(JobStoreTest, KeepsTheHeadersOfResults) {
    Job job = job_named("a");
    ASSERT_TRUE(store_->add(job, kComputeRequest));
    job.status = JobStatus::Succeeded;
    job.finished = time_now();
    job.headers = {{"X-Radius", "0.5"}, {"X-Repaired", R"([{"pointer":"/polygon","detail":"crosses: itself"}])"}};
    ASSERT_TRUE(store_->finish(job, "result"));
    const Job found = **store_->find("a");
    ASSERT_EQ(found.headers.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(found.headers[i].name, job.headers[i].name);
        EXPECT_EQ(found.headers[i].value, job.headers[i].value);
    }
    EXPECT_FALSE(found.failure);
}

TEST_P(JobStoreTest, RemovesAndDropsTheOldestFirst) {
    const Time now = time_now();
    const std::chrono::milliseconds second(1000);
    add_finished(*store_, "newest", now, "result");
    add_finished(*store_, "oldest", now - 3 * second, "result");
    add_finished(*store_, "older", now - 2 * second, "result");
    ASSERT_TRUE(store_->add(job_named("waits"), kComputeRequest));
    EXPECT_EQ(*store_->first_finished(), now - 3 * second);

    EXPECT_TRUE(*store_->drop_oldest_result());
    EXPECT_TRUE((*store_->find("oldest"))->dropped);
    EXPECT_EQ(*store_->result("oldest"), std::nullopt);
    EXPECT_FALSE((*store_->find("older"))->dropped);

    EXPECT_EQ(*store_->remove_finished(now - second, 1), 1u);
    EXPECT_EQ(*store_->find("oldest"), std::nullopt);
    EXPECT_EQ(*store_->remove_finished(now - second, 5), 1u);
    EXPECT_EQ(*store_->first_finished(), now);
    EXPECT_TRUE(*store_->drop_oldest_result());
    EXPECT_FALSE(*store_->drop_oldest_result());
    EXPECT_EQ(*store_->remove_finished(now, 5), 1u);
    EXPECT_EQ(*store_->first_finished(), std::nullopt);
    EXPECT_TRUE(*store_->find("waits"));
}

TEST_P(JobStoreTest, IsUsedByManyThreads) {
    constexpr int kThreads = 4;
    constexpr int kJobs = 25;
    {
        std::vector<std::jthread> threads;
        for (int thread = 0; thread < kThreads; ++thread) {
            threads.emplace_back([this, thread] {
                for (int i = 0; i < kJobs; ++i) {
                    const std::string id = std::to_string(thread) + "-" + std::to_string(i);
                    add_finished(*store_, id, time_now(), id);
                    EXPECT_EQ(**store_->result(id), id);
                    if (i % 2 == 0) {
                        EXPECT_TRUE(*store_->remove(id));
                    }
                }
            });
        }
    }
    EXPECT_EQ(*store_->remove_finished(Time::max(), kThreads * kJobs), kThreads * (kJobs / 2));
    EXPECT_EQ(store_->bytes(), 0u);
}

}  // namespace
}  // namespace ccdt::server

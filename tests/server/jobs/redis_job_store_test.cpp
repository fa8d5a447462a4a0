#include "server/jobs/redis_job_store.h"

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/jobs/example_jobs.h"
#include "tests/server/redis/local_redis.h"

namespace ccdt::server {
namespace {

using test::add;
using test::add_finished;
using test::job_named;
using test::kComputeRequest;
using test::succeeded;

/// What may happen to a Redis that others use as well.
class RedisJobStoreTest : public testing::Test {
protected:
    std::unique_ptr<JobStore> open(const JobLimits& limits = {}) { return open_at(client_, limits); }

    static std::unique_ptr<JobStore> open_at(RedisClient& client, const JobLimits& limits = {}) {
        const auto ignore = [](const std::string&) {};
        return std::make_unique<RedisJobStore>(client, limits, RedisJobStore::Notes{ignore, ignore, ignore});
    }

    void call(const std::vector<std::string>& words) {
        const auto reply = client_.run(RedisCommand(words.begin(), words.end()));
        ASSERT_TRUE(reply) << reply.error().message;
    }

    test::LocalRedis redis_;
    RedisClient client_{redis_.address()};
};

TEST_F(RedisJobStoreTest, PassesOverJobsThatAreGone) {
    const auto store = open();
    for (int i = 0; i < 40; ++i) add(*store, job_named("gone-" + std::to_string(i)));
    add(*store, job_named("here"));
    for (int i = 0; i < 40; ++i) call({"DEL", "ccdt:1:job:gone-" + std::to_string(i)});
    const auto job = store->claim(1000);
    ASSERT_TRUE(job && *job) << job.error().message;
    EXPECT_EQ((*job)->id, "here");
    EXPECT_EQ(store->load()->queued, 0u);
}

TEST_F(RedisJobStoreTest, TakesNoLeaseOfAJobThatIsGone) {
    const auto store = open({.lease = std::chrono::milliseconds(1)});
    add(*store, job_named("gone"));
    ASSERT_EQ((**store->claim(1000)).id, "gone");
    call({"DEL", "ccdt:1:job:gone"});
    while (store->load()->running > 0) {
        EXPECT_EQ(store->claim(1000), std::nullopt);
        std::this_thread::yield();
    }
    add_finished(*store, "next", "result");
}

TEST_F(RedisJobStoreTest, MakesRoomWhereJobsAreGone) {
    const auto bytes = JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest));
    const auto store = open({.bytes = 3 * bytes});
    for (const char* id : {"gone", "older", "old"}) add_finished(*store, id, "result");
    call({"DEL", "ccdt:1:job:gone"});
    add(*store, job_named("new"));
    EXPECT_TRUE(store->find("new")->has_value());
}

TEST_F(RedisJobStoreTest, TellsOfKeysThatAreNotItsOwn) {
    const auto store = open();
    for (const char* name : {"queue", "had", "waiting", "leases", "finished", "results", "state"}) {
        const std::string key = std::string("ccdt:1:") + name;
        call({"SET", key, "another's"});
        Job job = job_named(std::string("before-") + name);
        const auto ended = store->add(job, kComputeRequest)
                               .and_then([&](JobStore::Added) { return store->claim(1000); })
                               .and_then([&](const auto& claimed) { return store->finish(*claimed, "result"); });
        ASSERT_FALSE(ended) << name;
        EXPECT_EQ(ended.error().code, ErrorCode::Internal);
        EXPECT_NE(ended.error().message.find("WRONGTYPE"), std::string::npos) << ended.error().message;
        call({"FLUSHALL"});
        add_finished(*store, std::string("after-") + name, "result");
    }
}

TEST_F(RedisJobStoreTest, LosesAllJobsOnly) {
    const auto store = open();
    add(*store, job_named("running"));
    const Job running = **store->claim(1000);
    add(*store, job_named("waiting"));
    call({"FLUSHALL"});
    call({"SCRIPT", "FLUSH"});
    EXPECT_EQ(store->hold(running)->owned, JobStore::Owned::Lost);
    EXPECT_EQ(store->finish(succeeded(running, "result"), "result"), std::nullopt);
    EXPECT_EQ(store->find("waiting"), std::nullopt);
    EXPECT_EQ(store->claim(1000), std::nullopt);
    EXPECT_EQ(store->load()->bytes, 0u);
    add_finished(*store, "next", "result");
}

TEST_F(RedisJobStoreTest, WaitsForACopyThatMayNotBeWritten) {
    add(*open(), job_named("before"));
    const test::LocalRedis copy({"--replicaof", "127.0.0.1", redis_.address().port});
    RedisClient client(copy.address());
    const auto store = open_at(client);
    while (!store->find("before").value_or(std::nullopt)) std::this_thread::yield();
    Job job = job_named("now");
    EXPECT_EQ(store->add(job, kComputeRequest).error().code, ErrorCode::Stopped);
    EXPECT_EQ(store->claim(1000).error().code, ErrorCode::Stopped);
    ASSERT_TRUE(client.run(RedisCommand{"REPLICAOF", "NO", "ONE"}));
    EXPECT_EQ((**store->claim(1000)).id, "before");
    add(*store, job);
}

}  // namespace
}  // namespace ccdt::server

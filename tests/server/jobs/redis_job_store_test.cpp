// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/redis_job_store.h"

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/jobs/example_jobs.h"
#include "tests/server/redis/local_redis.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using test::add;
using test::add_finished;
using test::job_named;
using test::kComputeRequest;
using test::succeeded;

/// Tests the effects of other programs that use the same Redis.
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

    /// Replaces the value of a key by the result of a command that writes junk.
    void damage(const std::string& key, std::vector<std::string> junk) {
        call({"DEL", key});
        junk.insert(junk.begin() + 1, key);
        call(junk);
    }

    test::LocalRedis redis_;
    std::vector<std::string> reports_;
    RedisClient client_{redis_.address(), RedisClient::kDeadline,
                        [this](const std::string& report) { reports_.push_back(report); }};
};

/// Commands that write a value of each type; the key is inserted.
const std::vector<std::string> kJunk[] = {{"SET", "junk"},          {"LPUSH", "junk"},        {"SADD", "junk"},
                                          {"ZADD", "1", "junk"},    {"HSET", "junk", "junk"}, {"HSET", "turn", "junk"},
                                          {"HSET", "bytes", "junk"}};

TEST_F(RedisJobStoreTest, SkipsMissingJobs) {
    const auto store = open();
    for (int i = 0; i < 40; ++i) add(*store, job_named("gone-" + std::to_string(i)));
    add(*store, job_named("here"));
    for (int i = 0; i < 40; ++i) call({"DEL", "ccdt:1:job:gone-" + std::to_string(i)});
    const auto job = store->claim(1000);
    ASSERT_TRUE(job && *job) << job.error().message;
    EXPECT_EQ((*job)->id, "here");
    EXPECT_EQ(store->load()->queued, 0u);
}

TEST_F(RedisJobStoreTest, DropsLeasesOfMissingJobs) {
    const auto store = open({.lease = std::chrono::milliseconds(1)});
    add(*store, job_named("gone"));
    ASSERT_EQ((**store->claim(1000)).id, "gone");
    call({"DEL", "ccdt:1:job:gone"});
    ASSERT_TRUE(test::wait_until("the lease of a missing job to be dropped", [&] {
        EXPECT_EQ(store->claim(1000), std::nullopt);
        return store->load()->running == 0;
    }));
    add_finished(*store, "next", "result");
}

TEST_F(RedisJobStoreTest, FreesTheBytesOfMissingJobs) {
    const auto bytes = JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest));
    const auto store = open({.bytes = 3 * bytes});
    for (const char* id : {"gone", "older", "old"}) add_finished(*store, id, "result");
    call({"DEL", "ccdt:1:job:gone"});
    add(*store, job_named("new"));
    EXPECT_TRUE(store->find("new")->has_value());
}

TEST_F(RedisJobStoreTest, RebuildsDamagedSharedKeys) {
    const auto store = open();
    for (const char* name : {"queue", "had", "waiting", "leases", "finished", "results", "webhooks", "state"}) {
        for (const auto& junk : kJunk) {
            SCOPED_TRACE(std::string(name) + " " + junk[0]);
            call({"FLUSHALL"});
            add_finished(*store, "finished", "result");
            add(*store, job_named("running"));
            Job running = **store->claim(1000);
            running.status = JobStatus::Running;
            ASSERT_TRUE(store->renew(running));
            add(*store, job_named("waiting"));
            damage(std::string("ccdt:1:") + name, junk);
            if (HasFatalFailure()) return;

            for (const char* id : {"finished", "running", "waiting"}) EXPECT_TRUE(*store->find(id)) << id;
            add(*store, job_named("next"));
            EXPECT_EQ(store->result("finished"), "result");
            EXPECT_EQ(store->renew(running)->owned, JobStore::Owned::Still);
            for (int remaining = 2; remaining > 0; --remaining) {
                const auto claimed = store->claim(1000);
                ASSERT_TRUE(claimed && *claimed) << (claimed ? "nothing" : claimed.error().message);
                EXPECT_GT((*claimed)->claim, running.claim);
                EXPECT_TRUE(store->finish(succeeded(**claimed, "result"), "result")->has_value());
            }
            EXPECT_TRUE(store->finish(succeeded(running, "result"), "result")->has_value());
            for (const char* id : {"finished", "running", "waiting", "next"}) EXPECT_EQ(store->remove(id), true);
            EXPECT_EQ(*store->load(), (JobStore::Load{}));
        }
    }
}

TEST_F(RedisJobStoreTest, RestoresWebhooksAfterDamage) {
    const auto store = open();
    Job job = job_named("a");
    job.callback = "https://example.org";
    add(*store, job);
    ASSERT_TRUE(*store->finish(succeeded(**store->claim(1000), "result"), "result"));
    damage("ccdt:1:webhooks", kJunk[0]);
    EXPECT_EQ((*store->claim_webhook(std::chrono::hours(1)))->job.callback, job.callback);
}

TEST_F(RedisJobStoreTest, SendsWebhooksOfJobsThatEarlierReleasesHaveFinished) {
    const auto store = open();
    Job job = job_named("a");
    job.callback = "https://example.org";
    add(*store, job);
    EXPECT_EQ(*store->claim_webhook(std::chrono::milliseconds(1)), std::nullopt);
    call({"RENAME", "ccdt:1:webhooks", "hidden"});  // so that finish() does not change the set
    ASSERT_TRUE(*store->finish(succeeded(**store->claim(1000), "result"), "result"));
    call({"RENAME", "hidden", "ccdt:1:webhooks"});
    EXPECT_TRUE(test::wait_until("a second look", [&] { return *store->claim_webhook(std::chrono::hours(1)); }));
}

TEST_F(RedisJobStoreTest, ReportsDamagedKeys) {
    const auto store = open();
    for (const char* name :
         {"queue", "had", "waiting", "leases", "finished", "results", "webhooks", "state", "job:waiting"}) {
        const std::string key = std::string("ccdt:1:") + name;
        call({"FLUSHALL"});
        add(*store, job_named("waiting"));
        call({"SET", key, "junk"});
        const auto before = store->damages();
        ASSERT_TRUE(store->find("waiting")) << key;
        add(*store, job_named("next"));
        EXPECT_EQ(store->damages(), before + 1) << key;
        EXPECT_NE(reports_.back().find("the key " + key + " "), std::string::npos) << reports_.back();
    }
}

TEST_F(RedisJobStoreTest, RecountsWaitingJobsAfterDamage) {
    const auto store = open();
    add(*store, job_named("first"));
    call({"HSET", "ccdt:1:waiting", "key alice", "junk"});
    add(*store, job_named("second"));
    for (const char* id : {"first", "second"}) EXPECT_EQ((**store->claim(1000)).id, id);
    EXPECT_EQ(client_.run(RedisCommand{"EXISTS", "ccdt:1:waiting"})->number, 0);
}

/// Fields of a job that have a fixed format, so that junk in them is detected.
constexpr const char* kFields[] = {"memory",   "seconds",   "status", "starts", "claim",    "created",     "place",
                                   "fraction", "iteration", "turn",   "bytes",  "finished", "result_bytes"};

TEST_F(RedisJobStoreTest, FailsDamagedJobs) {
    const auto store = open();
    for (const char* field : kFields) {
        for (const char* id : {"waiting", "running"}) {
            SCOPED_TRACE(std::string(id) + " " + field);
            call({"FLUSHALL"});
            add(*store, job_named("running"));
            const Job running = **store->claim(1000);
            add(*store, job_named("waiting"));
            add(*store, job_named("next"));
            call({"HSET", std::string("ccdt:1:job:") + id, field, "junk"});

            const auto found = store->find(id);
            ASSERT_TRUE(found && *found) << (found ? "nothing" : found.error().message);
            EXPECT_EQ((*found)->status, JobStatus::Failed);
            EXPECT_EQ((*found)->owner, "alice");
            ASSERT_TRUE((*found)->failure);
            EXPECT_NE((*found)->failure->error.message.find("damaged"), std::string::npos);
            EXPECT_EQ(store->request(id), std::nullopt);
            EXPECT_EQ(store->cancel(id), std::nullopt);
            const bool owned = store->finish(succeeded(running, "result"), "result")->has_value();
            EXPECT_EQ(owned, id != std::string("running"));
            while (const auto claimed = *store->claim(1000)) EXPECT_NE(claimed->id, id);
            EXPECT_EQ(store->load()->queued, 0u);
        }
    }
}

TEST_F(RedisJobStoreTest, ClaimsJobsAfterDamagedOnes) {
    const auto store = open();
    for (const char* field : kFields) {
        SCOPED_TRACE(field);
        call({"FLUSHALL"});
        add(*store, job_named("damaged"));
        add(*store, job_named("next"));
        call({"HSET", "ccdt:1:job:damaged", field, "junk"});
        EXPECT_EQ((**store->claim(1000)).id, "next");
        EXPECT_EQ((**store->find("damaged")).status, JobStatus::Failed);
    }
    for (const auto& junk : kJunk) {
        SCOPED_TRACE(junk[0]);
        call({"FLUSHALL"});
        add(*store, job_named("damaged"));
        add(*store, job_named("next"));
        damage("ccdt:1:job:damaged", junk);
        EXPECT_EQ((**store->claim(1000)).id, "next");
        EXPECT_EQ(store->find("damaged"), std::nullopt);
    }
}

TEST_F(RedisJobStoreTest, DoesNotFinishJobsWithADamagedKey) {
    const auto store = open();
    for (const auto& junk : kJunk) {
        SCOPED_TRACE(junk[0]);
        add(*store, job_named("running"));
        const Job running = **store->claim(1000);
        damage("ccdt:1:job:running", junk);
        EXPECT_EQ(store->renew(running)->owned, JobStore::Owned::Lost);
        EXPECT_EQ(store->finish(succeeded(running, "result"), "result"), std::nullopt);
        EXPECT_EQ(*store->load(), (JobStore::Load{}));
    }
}

TEST_F(RedisJobStoreTest, DetectsDamagedBodies) {
    const std::string large(3 * JobStore::kPiece, 'x');
    const auto store = open();
    for (const std::string& body : {std::string("body"), large}) {
        ComputeRequest request = kComputeRequest;
        request.body = body;
        Job job = job_named("any");
        ASSERT_EQ(store->add(job, request), JobStore::Added::Accepted);
        const Job claimed = **store->claim(1000);
        for (const char* field : {"path", "query", "content_type", "accept", "size", "0"}) {
            const auto stored = client_.run(RedisCommand{"HGET", "ccdt:1:question:any", field})->text;
            call({"HSET", "ccdt:1:question:any", field, "junk"});
            EXPECT_EQ(store->request("any").error().code, ErrorCode::Unusable) << field;
            call({"HSET", "ccdt:1:question:any", field, stored});
            EXPECT_TRUE(*store->request("any"));
        }
        call({"SET", "ccdt:1:question:any", "junk"});
        EXPECT_EQ(store->request("any").error().code, ErrorCode::Unusable);
        call({"SET", "ccdt:1:result:any", "junk"});
        EXPECT_TRUE(store->finish(succeeded(claimed, body), body)->has_value())
            << "the damaged key must be overwritten";
        EXPECT_EQ(store->result("any"), body);
        call({"HSET", "ccdt:1:result:any", "0", "junk"});
        EXPECT_EQ(store->result("any").error().code, ErrorCode::Unusable);
        call({"SET", "ccdt:1:result:any", "junk"});
        EXPECT_EQ(store->result("any").error().code, ErrorCode::Unusable);
        EXPECT_EQ(store->remove("any"), true);
    }
}

TEST_F(RedisJobStoreTest, ContinuesAfterLosingAllKeys) {
    const auto store = open();
    add(*store, job_named("running"));
    const Job running = **store->claim(1000);
    add(*store, job_named("waiting"));
    call({"FLUSHALL"});
    call({"SCRIPT", "FLUSH"});
    EXPECT_EQ(store->renew(running)->owned, JobStore::Owned::Lost);
    EXPECT_EQ(store->finish(succeeded(running, "result"), "result"), std::nullopt);
    EXPECT_EQ(store->find("waiting"), std::nullopt);
    EXPECT_EQ(store->claim(1000), std::nullopt);
    EXPECT_EQ(store->load()->bytes, 0u);
    add_finished(*store, "next", "result");
}

TEST_F(RedisJobStoreTest, TreatsAReadOnlyReplicaAsUnavailable) {
    add(*open(), job_named("before"));
    const test::LocalRedis copy({"--replicaof", "127.0.0.1", redis_.address().port});
    RedisClient client(copy.address());
    const auto store = open_at(client);
    ASSERT_TRUE(test::wait_until("the replica to have the job",
                                 [&] { return store->find("before").value_or(std::nullopt).has_value(); }));
    Job job = job_named("now");
    EXPECT_EQ(store->add(job, kComputeRequest).error().code, ErrorCode::Stopped);
    EXPECT_EQ(store->claim(1000).error().code, ErrorCode::Stopped);
    ASSERT_TRUE(client.run(RedisCommand{"REPLICAOF", "NO", "ONE"}));
    EXPECT_EQ((**store->claim(1000)).id, "before");
    add(*store, job);
}

}  // namespace
}  // namespace ccdt::server

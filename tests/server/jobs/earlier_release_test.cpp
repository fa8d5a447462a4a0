#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/jobs/redis_job_store.h"
#include "server/jobs/sqlite.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/server/jobs/example_jobs.h"
#include "tests/server/redis/local_redis.h"

namespace ccdt::server {
namespace {

using nlohmann::json;
using test::job_named;
using test::kComputeRequest;
using test::succeeded;

/// Reads a file that a server of the previous release left, or what it answered, as tests/data/jobs/make recorded it.
std::string read_before(const std::string& name) {
    std::ifstream file(CCDT_TEST_DATA "/jobs/before/" + name);
    EXPECT_TRUE(file) << name;
    return {std::istreambuf_iterator<char>(file), {}};
}

std::unique_ptr<JobStore> open_redis(RedisClient& client, const JobLimits& limits) {
    const auto ignore = [](const std::string&) {};
    return std::make_unique<RedisJobStore>(client, limits, RedisJobStore::Notes{ignore, ignore, ignore});
}

/// Keeps jobs that ended long ago, with leases that have expired.
constexpr JobLimits kLasting{.ttl = std::chrono::hours(1'000'000), .lease = std::chrono::milliseconds(1)};

Job claim_some(JobStore& store) {
    while (true) {
        auto job = store.claim(std::size_t{1} << 30);
        EXPECT_TRUE(job);
        if (!job || *job) return job ? **std::move(job) : Job{};
        std::this_thread::yield();
    }
}

std::string id_of(const json& told) {
    return told["job"].get<std::string>().substr(std::string("/jobs/").size());
}

void expect_all_taken_over(JobStore& store, const json& told) {
    std::set<std::string> jobs;
    for (const auto& job : told) jobs.insert(id_of(job));
    for (const char* end : {"succeeded", "failed", "cancelled"}) {
        const auto job = store.find(id_of(told[end]));
        ASSERT_TRUE(job && *job) << end;
        EXPECT_EQ(json::parse(status_json(**job)), told[end]["status"]);
    }
    EXPECT_EQ(**store.result(id_of(told["succeeded"])), told["succeeded"]["result"]);
    for (int left = 2; left > 0; --left) {
        const Job job = claim_some(store);
        const bool had_begun = job.id == id_of(told["running"]);
        EXPECT_EQ(job.starts, had_begun ? 2 : 1);
        const auto request = store.request(job.id);
        ASSERT_TRUE(request && *request) << job.id;
        EXPECT_EQ(json::parse((*request)->body), told[had_begun ? "running" : "waiting"]["request"]);
        ASSERT_TRUE(*store.finish(succeeded(job, "result"), "result"));
        EXPECT_EQ(**store.result(job.id), "result");
    }
    EXPECT_EQ(store.damages(), 0u);
    for (const auto& id : jobs) EXPECT_TRUE(*store.remove(id));
    EXPECT_EQ(store.load()->bytes, 0u);
}

TEST(EarlierRelease, LeavesJobsThatSqliteTakesOver) {
    std::string folder = (std::filesystem::path(testing::TempDir()) / "earlier-XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    Database(folder + "/jobs.sqlite").execute(read_before("jobs.sql").c_str());
    expect_all_taken_over(**SqliteJobStore::open(folder, kLasting), json::parse(read_before("told.json"))["folder"]);
    std::filesystem::remove_all(folder);
}

class EarlierReleaseByRedis : public testing::Test {
protected:
    test::LocalRedis redis_;
    RedisClient client_{redis_.address()};
};

TEST_F(EarlierReleaseByRedis, LeavesJobsThatRedisTakesOver) {
    std::istringstream lines(read_before("redis.jsonl"));
    for (std::string line; std::getline(lines, line);) {
        const auto words = json::parse(line).get<std::vector<std::string>>();
        ASSERT_TRUE(client_.run(RedisCommand(words.begin(), words.end())));
    }
    const auto told = json::parse(read_before("told.json"))["redis"];
    const std::string running = id_of(told["running"]);
    ASSERT_TRUE(client_.run(RedisCommand{"ZADD", "ccdt:1:leases", "0", running}));
    expect_all_taken_over(*open_redis(client_, kLasting), told);
}

/// Operations of a server on jobs, whatever its release.
class Worker {
public:
    virtual ~Worker() = default;

    virtual bool add(const std::string& id) = 0;
    virtual std::optional<Job> claim() = 0;  ///< with id and number of the claim
    virtual bool hold(const Job& job) = 0;
    virtual void give_back(const Job& job) = 0;
    virtual bool finish(const Job& job, const std::string& result) = 0;
    virtual bool cancel(const std::string& id) = 0;
    virtual bool remove(const std::string& id) = 0;
    virtual std::string status(const std::string& id) = 0;  ///< empty: there is no such job
};

class WorkerNow : public Worker {
public:
    explicit WorkerNow(RedisClient& client) : store_(open_redis(client, {})) {}

    bool add(const std::string& id) override {
        Job job = job_named(id);
        return store_->add(job, kComputeRequest) == JobStore::Added::Accepted;
    }
    std::optional<Job> claim() override { return store_->claim(1000).value(); }
    bool hold(const Job& job) override {
        Job running = job;
        running.status = JobStatus::Running;
        return store_->hold(running).value().owned == JobStore::Owned::Still;
    }
    void give_back(const Job& job) override { EXPECT_TRUE(store_->give_back(job)); }
    bool finish(const Job& job, const std::string& result) override {
        EXPECT_EQ(store_->request(job.id).value().value().body, kComputeRequest.body);
        return store_->finish(succeeded(job, result), result).value().has_value();
    }
    bool cancel(const std::string& id) override { return store_->cancel(id).value().has_value(); }
    bool remove(const std::string& id) override { return store_->remove(id).value(); }
    std::string status(const std::string& id) override {
        const auto job = store_->find(id).value();
        return job ? std::string(name_of(job->status)) : "";
    }

private:
    const std::unique_ptr<JobStore> store_;
};

/// Runs the scripts of the previous release as its servers did.
class WorkerBefore : public Worker {
public:
    explicit WorkerBefore(RedisClient& client) : client_(client) {}

    bool add(const std::string& id) override {
        const std::string pieces = "ccdt:1:pieces:" + id + ":0";
        const std::string size = std::to_string(kComputeRequest.body.size());
        call({"HSET", pieces, "size", size, "path", kComputeRequest.path, "query", kComputeRequest.query,
              "content_type", kComputeRequest.content_type, "accept", kComputeRequest.accept, "0",
              kComputeRequest.body});
        call({"EXPIRE", pieces, "120"});
        const std::string bytes = std::to_string(JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest)));
        const auto reply = run("add", {id, pieces, bytes, "1000", "1000000000", "alice", "key alice", "1000", "0.5"});
        return reply.items.at(0).text == "accepted";
    }
    std::optional<Job> claim() override {
        const auto reply = run("claim", {"1000", "15000", "1"});
        if (reply.items.empty()) return std::nullopt;
        Job job;
        job.id = reply.items.at(0).text;
        const auto& fields = reply.items.at(1).items;
        for (std::size_t i = 0; i + 1 < fields.size(); i += 2)
            if (fields[i].text == "claim") job.claim = std::stoull(fields[i + 1].text);
        return job;
    }
    bool hold(const Job& job) override {
        const std::string claim = std::to_string(job.claim);
        return run("hold", {job.id, claim, "15000", "running", "0.5", "3", ""}).items.at(0).text == "still";
    }
    void give_back(const Job& job) override { run("give_back", {job.id, std::to_string(job.claim)}); }
    bool finish(const Job& job, const std::string& result) override {
        EXPECT_EQ(call({"HGET", "ccdt:1:question:" + job.id, "0"}).text, kComputeRequest.body);
        const std::string claim = std::to_string(job.claim);
        const std::string pieces = "ccdt:1:pieces:" + job.id + ":" + claim;
        const std::string size = std::to_string(result.size());
        call({"HSET", pieces, "size", size, "0", result});
        const auto reply =
            run("finish", {job.id, claim, pieces, size, std::to_string(JobStore::bytes_of_job(result.size())),
                           "1000000000", "status", "succeeded", "fraction", "1", "iteration", "5", "media_type",
                           "text/plain", "partial", "0", "headers", ""});
        return reply.items.at(0).text == "finished";
    }
    bool cancel(const std::string& id) override {
        return !run("cancel", {id, std::to_string(JobStore::bytes_of_job(0))}).items.empty();
    }
    bool remove(const std::string& id) override { return run("remove", {id}).number == 1; }
    std::string status(const std::string& id) override {
        const auto fields = run("find", {id, "3600000"}).items;
        for (std::size_t i = 0; i + 1 < fields.size(); i += 2)
            if (fields[i].text == "status") return fields[i + 1].text;
        return "";
    }

private:
    RedisReply call(const std::vector<std::string>& words) {
        const auto reply = client_.run(RedisCommand(words.begin(), words.end()));
        EXPECT_TRUE(reply) << reply.error().message;
        return reply.value_or(RedisReply());
    }

    RedisReply run(const std::string& name, const std::vector<std::string>& arguments) {
        const auto read = [](const std::string& script) { return read_before("redis_scripts/" + script + ".lua"); };
        const RedisScript script("allow-oom", {read("common"), read(name)});
        const auto reply = client_.run(script, "ccdt:1:", RedisCommand(arguments.begin(), arguments.end()));
        EXPECT_TRUE(reply) << name << ": " << reply.error().message;
        return reply.value_or(RedisReply());
    }

    RedisClient& client_;
};

/// Servers of two releases share jobs for a while during an update. Each continues jobs that the other has begun.
TEST_F(EarlierReleaseByRedis, SharesJobsWithThisRelease) {
    WorkerNow now(client_);
    WorkerBefore before(client_);
    std::mt19937 chance(7);
    const auto either = [&]() -> Worker& { return chance() % 2 == 0 ? static_cast<Worker&>(now) : before; };
    std::set<std::string> waiting;
    std::map<std::string, Job> claimed;
    std::set<std::string> ended;
    const auto any_of = [&](const auto& some) {
        return *std::next(some.begin(), static_cast<std::ptrdiff_t>(chance() % some.size()));
    };
    for (int step = 0; step < 1500; ++step) {
        const auto choice = chance() % 7;
        if (choice < 2) {
            const std::string id = "job-" + std::to_string(step);
            ASSERT_TRUE(either().add(id));
            waiting.insert(id);
        } else if (choice < 4) {
            const auto job = either().claim();
            ASSERT_EQ(job.has_value(), !waiting.empty());
            if (!job) continue;
            ASSERT_EQ(waiting.erase(job->id), 1u);
            claimed[job->id] = *job;
        } else if (!claimed.empty()) {
            const Job job = any_of(claimed).second;
            ASSERT_TRUE(either().hold(job));
            ASSERT_EQ(either().status(job.id), "running");
            if (choice == 4) {
                ASSERT_TRUE(either().finish(job, "result of " + job.id));
            } else if (choice == 5) {
                either().give_back(job);
                waiting.insert(job.id);
            } else {
                ASSERT_TRUE(either().cancel(job.id));
            }
            ASSERT_EQ(either().status(job.id), choice == 4 ? "succeeded" : choice == 5 ? "queued" : "cancelled");
            ASSERT_FALSE(either().hold(job)) << "nobody's any more";
            claimed.erase(job.id);
            if (choice != 5) ended.insert(job.id);
        }
        if (!ended.empty() && chance() % 4 == 0) {
            const auto id = any_of(ended);
            ASSERT_TRUE(either().remove(id));
            ASSERT_EQ(either().status(id), "");
            ended.erase(id);
        }
    }
    EXPECT_GT(waiting.size() + claimed.size() + ended.size(), 10u) << "there was something to do";
    for (const auto& ids : {waiting, ended})
        for (const auto& id : ids) EXPECT_TRUE(either().remove(id));
    for (const auto& [id, job] : claimed) EXPECT_TRUE(either().remove(id));
    const auto keys = client_.run(RedisCommand{"KEYS", "*"});
    ASSERT_EQ(keys->items.size(), 1u);
    EXPECT_EQ(keys->items[0].text, "ccdt:1:state");
    EXPECT_EQ(client_.run(RedisCommand{"HGET", "ccdt:1:state", "bytes"})->text, "0");
}

}  // namespace
}  // namespace ccdt::server

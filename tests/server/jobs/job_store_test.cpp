// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/jobs/redis_job_store.h"
#include "server/jobs/sqlite_job_store.h"
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

/// The storage of one test, initially empty. The destructor removes it.
class Place {
public:
    virtual ~Place() = default;

    /// Opens a store. Only shared stores may be open several times.
    /// @returns  null on failure
    virtual std::unique_ptr<JobStore> open(const JobLimits& limits) = 0;
};

class Memory : public Place {
public:
    std::unique_ptr<JobStore> open(const JobLimits& limits) override {
        return SqliteJobStore::open("", limits).value_or(nullptr);
    }
};

class Folder : public Place {
public:
    Folder() : path_(std::filesystem::path(testing::TempDir()) / "any-jobs-XXXXXX") {
        std::string name = path_.string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        path_ = name;
    }
    ~Folder() override { std::filesystem::remove_all(path_); }

    std::unique_ptr<JobStore> open(const JobLimits& limits) override {
        return SqliteJobStore::open(path_.string(), limits).value_or(nullptr);
    }

private:
    std::filesystem::path path_;
};

class Redis : public Place {
public:
    std::unique_ptr<JobStore> open(const JobLimits& limits) override {
        const auto ignore = [](const std::string&) {};
        return std::make_unique<RedisJobStore>(client_, limits, RedisJobStore::Notes{ignore, ignore, ignore});
    }

private:
    test::LocalRedis redis_;
    RedisClient client_{redis_.address()};
};

/// A kind of job store. All tests of this file run for each kind.
struct Kind {
    const char* name;
    bool outlives_its_server;
    std::unique_ptr<Place> (*make)();

    friend void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }
};

const Kind kKinds[] = {
    {"SqliteInMemory", false, [] { return std::unique_ptr<Place>(std::make_unique<Memory>()); }},
    {"SqliteInAFolder", true, [] { return std::unique_ptr<Place>(std::make_unique<Folder>()); }},
    {"Redis", true, [] { return std::unique_ptr<Place>(std::make_unique<Redis>()); }},
};

/// Records the notifications of a store as texts.
class Heard : public JobListener {
public:
    void work() override { add("work"); }
    void changed(const std::string& id) override { add("changed " + id); }
    void stop(const std::string& id) override { add("stop " + id); }
    void missed() override { add("missed"); }

    /// Waits for a notification.
    bool has(const std::string& news) {
        std::unique_lock lock(mutex_);
        return more_.wait_for(lock, test::kPatience, [&] { return std::ranges::count(heard_, news) > 0; });
    }

private:
    void add(std::string news) {
        const std::lock_guard lock(mutex_);
        heard_.push_back(std::move(news));
        more_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable more_;
    std::vector<std::string> heard_;
};

class JobStoreTest : public testing::TestWithParam<Kind> {
protected:
    void SetUp() override { open_with({}); }

    /// Closes the store, and opens it again with other limits.
    void open_with(const JobLimits& limits) {
        store_.reset();
        store_ = place_->open(limits);
        ASSERT_NE(store_, nullptr);
    }

    /// Claims a job, which must exist.
    Job claim(std::size_t memory = kMemory) {
        auto job = store_->claim(memory);
        EXPECT_TRUE(job && *job);
        return job && *job ? **std::move(job) : Job{};
    }

    /// Waits until a lease has expired, and claims the job again.
    Job claim_again() {
        Result<std::optional<Job>> job;
        EXPECT_TRUE(test::wait_until("an expired lease", [&] {
            job = store_->claim(kMemory);
            return !job || *job;
        }));
        EXPECT_TRUE(job);
        return job && *job ? **std::move(job) : Job{};
    }

    Job find(const std::string& id) {
        auto job = store_->find(id);
        EXPECT_TRUE(job && *job) << id;
        return job && *job ? **std::move(job) : Job{};
    }

    /// Sets the listener. For shared stores, waits until notifications arrive.
    static void listen(JobStore& store, Heard& heard) {
        store.listen(&heard);
        if (store.is_shared()) {
            EXPECT_TRUE(heard.has("missed"));
        }
    }

    bool is_there(const std::string& id) { return store_->find(id)->has_value(); }
    std::size_t bytes() { return store_->load()->bytes; }

    static constexpr std::size_t kMemory = 1000;

    const std::unique_ptr<Place> place_ = GetParam().make();
    std::unique_ptr<JobStore> store_;
};

INSTANTIATE_TEST_SUITE_P(Any, JobStoreTest, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return kind.param.name; });

constexpr JobLimits kBrief{.lease = std::chrono::milliseconds(1)};

TEST_P(JobStoreTest, StoresJobsAndRequests) {
    Job job = job_named("a");
    const Time before = time_now();
    ASSERT_EQ(store_->add(job, kComputeRequest), JobStore::Added::Accepted);
    EXPECT_GE(job.created, before - std::chrono::seconds(1));
    add(*store_, job_named("b"));
    if (GetParam().outlives_its_server) open_with({});

    const Job found = find("a");
    EXPECT_EQ(found.id, job.id);
    EXPECT_EQ(found.owner, job.owner);
    EXPECT_EQ(found.client, job.client);
    EXPECT_EQ(found.traceparent, job.traceparent);
    EXPECT_EQ(found.cost.memory, job.cost.memory);
    EXPECT_EQ(found.cost.seconds, job.cost.seconds);
    EXPECT_EQ(found.status, JobStatus::Queued);
    EXPECT_EQ(found.starts, 0);
    EXPECT_EQ(found.created, job.created);
    EXPECT_EQ(found.started, std::nullopt);
    EXPECT_EQ(found.finished, std::nullopt);
    const auto request = store_->request("a");
    ASSERT_TRUE(request && *request);
    EXPECT_EQ((*request)->path, kComputeRequest.path);
    EXPECT_EQ((*request)->query, kComputeRequest.query);
    EXPECT_EQ((*request)->content_type, kComputeRequest.content_type);
    EXPECT_EQ((*request)->accept, kComputeRequest.accept);
    EXPECT_EQ((*request)->body, kComputeRequest.body);
    EXPECT_EQ(bytes(), 2 * JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest)));
    EXPECT_EQ(claim().id, "a") << "jobs must be claimed in the order of their arrival";
    EXPECT_EQ(claim().id, "b");
}

TEST_P(JobStoreTest, FindsNoUnknownJobs) {
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(*store_->request("a"), std::nullopt);
    EXPECT_EQ(*store_->result("a"), std::nullopt);
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_EQ(store_->renew(job_named("a"))->owned, JobStore::Owned::Lost);
    EXPECT_TRUE(store_->requeue(job_named("a"), false));
    EXPECT_EQ(*store_->finish(job_named("a"), "result"), std::nullopt);
    EXPECT_EQ(*store_->cancel("a"), std::nullopt);
    EXPECT_FALSE(*store_->remove("a"));
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(bytes(), 0u);
}

TEST_P(JobStoreTest, AddsAJobOnce) {
    add(*store_, job_named("a"));
    add(*store_, job_named("a"));
    EXPECT_EQ(store_->load()->queued, 1u);
    EXPECT_EQ(claim().id, "a");
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_EQ(bytes(), JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest)));
}

TEST_P(JobStoreTest, ReplacesTheRequestByTheResult) {
    const std::string result(
        "\0\xff"
        "bytes",
        7);
    add_finished(*store_, "a", result);
    if (GetParam().outlives_its_server) open_with({});
    EXPECT_EQ(*store_->request("a"), std::nullopt);
    EXPECT_EQ(**store_->result("a"), result);
    const Job job = find("a");
    EXPECT_EQ(job.status, JobStatus::Succeeded);
    EXPECT_EQ(job.result_bytes, result.size());
    EXPECT_EQ(job.media_type, "text/plain");
    EXPECT_GE(job.finished, job.created);
    EXPECT_EQ(bytes(), JobStore::bytes_of_job(result.size()));
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_TRUE(*store_->remove("a"));
    EXPECT_FALSE(*store_->remove("a"));
    EXPECT_EQ(*store_->find("a"), std::nullopt);
    EXPECT_EQ(*store_->result("a"), std::nullopt);
    EXPECT_EQ(bytes(), 0u);
}

TEST_P(JobStoreTest, StoresLargeRequestsAndResults) {
    std::string large(5'000'001, 'x');
    for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * i / 7);
    Job job = job_named("a");
    ComputeRequest request = kComputeRequest;
    request.body = large;
    ASSERT_EQ(store_->add(job, request), JobStore::Added::Accepted);
    EXPECT_EQ((**store_->request("a")).body, large);
    ASSERT_TRUE(*store_->finish(succeeded(claim(), large), large));
    EXPECT_EQ(**store_->result("a"), large);
    EXPECT_EQ(bytes(), JobStore::bytes_of_job(large.size()));
}

TEST_P(JobStoreTest, StoresResultsInPieces) {
    for (const std::size_t last : {std::size_t{0}, std::size_t{1}, JobStore::kPiece}) {
        add(*store_, job_named("a"));
        const Job job = claim();
        const std::string first(JobStore::kPiece, '1'), second(7, '2'), third(last, '3');
        EXPECT_EQ(store_->append_piece(job, {}, first), true);
        EXPECT_EQ(store_->append_piece(job, {1, first.size()}, second), true);
        const std::string all = first + second + third;
        ASSERT_TRUE(*store_->finish(succeeded(job, all), third, {2, first.size() + second.size()}));
        if (GetParam().outlives_its_server) open_with({});
        EXPECT_EQ(find("a").result_bytes, all.size());
        EXPECT_EQ(**store_->piece("a", 0), first);
        EXPECT_EQ(**store_->piece("a", 1), second);
        EXPECT_EQ(**store_->result("a"), all);
        EXPECT_EQ(bytes(), JobStore::bytes_of_job(all.size()));
        EXPECT_TRUE(*store_->remove("a"));
        EXPECT_EQ(*store_->piece("a", 0), std::nullopt);
        EXPECT_EQ(bytes(), 0u);
    }
}

TEST_P(JobStoreTest, DropsPiecesOfALostClaim) {
    open_with({.lease = std::chrono::milliseconds(1)});
    add(*store_, job_named("a"));
    const Job lost = claim();
    const std::string piece(1000, 'x');
    EXPECT_TRUE(store_->append_piece(lost, {}, piece));
    const Job job = claim_again();
    EXPECT_EQ(store_->append_piece(lost, {1, piece.size()}, piece), false);
    ASSERT_TRUE(*store_->finish(succeeded(job, "good"), "good"));
    EXPECT_EQ(**store_->result("a"), "good");
    EXPECT_EQ(bytes(), JobStore::bytes_of_job(4));
}

TEST_P(JobStoreTest, DropsPiecesOfJobsWithoutResult) {
    for (const bool cancelled : {true, false}) {
        add(*store_, job_named("a"));
        Job job = claim();
        EXPECT_EQ(store_->append_piece(job, {}, "piece"), true);
        job.status = JobStatus::Failed;
        EXPECT_TRUE(cancelled ? (*store_->cancel("a")).has_value() : (*store_->finish(job, {})).has_value());
        EXPECT_EQ(store_->append_piece(job, {1, 5}, "piece"), false);
        EXPECT_EQ(*store_->piece("a", 0), std::nullopt);
        EXPECT_EQ(bytes(), JobStore::bytes_of_job(0));
        EXPECT_TRUE(*store_->remove("a"));
    }
}

TEST_P(JobStoreTest, RefusesPiecesBeyondTheByteLimit) {
    open_with({.bytes = 20'000});
    add_finished(*store_, "done", "result");
    add(*store_, job_named("a"));
    Job job = claim();
    const std::string piece(9'000, 'x');
    EXPECT_EQ(store_->append_piece(job, {}, piece), true);
    for (const auto& refused : {store_->append_piece(job, {1, 9'000}, std::string(10'500, 'x')).map([](bool) {}),
                                store_->finish(job, std::string(10'500, 'x'), {1, 9'000}).map([](const auto&) {})}) {
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::LimitExceeded);
    }
    EXPECT_TRUE(is_there("done")) << "no result may be dropped for a piece that is refused";
    job.status = JobStatus::Failed;
    EXPECT_TRUE(*store_->finish(job, {})) << "a job without a result needs no space";
}

TEST_P(JobStoreTest, StoresBodiesOfAllSizes) {
    for (const std::size_t size : {1, 65'535, 65'536, 65'537, 1'048'576, 1'048'577, 2'097'152}) {
        std::string body(size, '\0');
        body.back() = 'x';
        Job job = job_named(std::to_string(size));
        ComputeRequest request = kComputeRequest;
        request.body = body;
        ASSERT_EQ(store_->add(job, request), JobStore::Added::Accepted);
        const auto found = store_->request(job.id);
        ASSERT_TRUE(found && *found);
        EXPECT_EQ((*found)->query, request.query);
        EXPECT_EQ((*found)->body, body);
        ASSERT_TRUE(*store_->finish(succeeded(claim(), body), body));
        EXPECT_EQ(**store_->result(job.id), body);
        EXPECT_TRUE(*store_->remove(job.id));
    }
    Job job = job_named("empty");
    ComputeRequest request = kComputeRequest;
    request.body.clear();
    ASSERT_EQ(store_->add(job, request), JobStore::Added::Accepted);
    EXPECT_EQ((**store_->request("empty")).body, "");
}

TEST_P(JobStoreTest, StoresFailures) {
    add(*store_, job_named("a"));
    Job job = claim();
    job.status = JobStatus::Failed;
    job.progress = {0.5, 3, 0.1};
    job.failure = Problem{422, {ErrorCode::Unusable, "crossing", "/polygon/2"}};
    ASSERT_TRUE(*store_->finish(job, {}));
    if (GetParam().outlives_its_server) open_with({});
    const Job found = find("a");
    EXPECT_EQ(found.status, JobStatus::Failed);
    EXPECT_EQ(found.progress.fraction, 0.5);
    EXPECT_EQ(found.progress.iteration, 3);
    EXPECT_EQ(found.progress.variation, 0.1);
    ASSERT_TRUE(found.failure);
    EXPECT_EQ(found.failure->status, 422);
    EXPECT_EQ(found.failure->error.message, "crossing");
    EXPECT_EQ(found.failure->error.field, "/polygon/2");
}

TEST_P(JobStoreTest, StoresTheHeadersOfResults) {
    add(*store_, job_named("a"));
    Job job = succeeded(claim(), "result");
    job.partial = true;
    job.headers = {{"X-Radius", "0.5"}, {"X-Repaired", R"([{"pointer":"/polygon","detail":"crosses: itself"}])"}};
    ASSERT_TRUE(*store_->finish(job, "result"));
    const Job found = find("a");
    EXPECT_TRUE(found.partial);
    ASSERT_EQ(found.headers.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(found.headers[i].name, job.headers[i].name);
        EXPECT_EQ(found.headers[i].value, job.headers[i].value);
    }
    EXPECT_FALSE(found.failure);
}

TEST_P(JobStoreTest, StoresTheProgressOfAClaimedJob) {
    add(*store_, job_named("a"));
    Job job = claim();
    EXPECT_EQ(job.starts, 1);
    EXPECT_GT(job.claim, 0u);
    EXPECT_EQ(find("a").status, JobStatus::Queued) << "a claimed job may wait in its server's queue";
    EXPECT_EQ(store_->renew(job)->owned, JobStore::Owned::Still);
    EXPECT_EQ(find("a").started, std::nullopt);
    job.status = JobStatus::Running;
    const auto began = store_->renew(job);
    job.progress = {0.25, 2, 0.1};
    EXPECT_EQ(store_->renew(job)->owned, JobStore::Owned::Still);
    const Job found = find("a");
    EXPECT_EQ(found.status, JobStatus::Running);
    EXPECT_EQ(found.started, began->now) << "only the first call sets the time of the start";
    EXPECT_EQ(found.progress.fraction, 0.25);
    EXPECT_EQ(found.progress.iteration, 2);
    EXPECT_EQ(found.progress.variation, 0.1);
    EXPECT_EQ(found.claim, job.claim);
    EXPECT_EQ(store_->load()->queued, 0u);
    EXPECT_EQ(store_->load()->running, 1u);
}

TEST_P(JobStoreTest, ReturnsJobsWithoutCountingTheStart) {
    add(*store_, job_named("a"));
    add(*store_, job_named("b"));
    Job job = claim();
    job.status = JobStatus::Running;
    ASSERT_TRUE(store_->renew(job));
    ASSERT_TRUE(store_->requeue(job, false));
    EXPECT_EQ(find("a").status, JobStatus::Queued);
    EXPECT_EQ(find("a").started, std::nullopt);
    EXPECT_EQ(find("a").starts, 0);
    const Job again = claim();
    EXPECT_EQ(again.id, "a") << "the returned job must be claimed first";
    EXPECT_EQ(again.starts, 1);
    EXPECT_GT(again.claim, job.claim);
    EXPECT_EQ(*store_->finish(succeeded(job, "late"), "late"), std::nullopt);
    EXPECT_TRUE(*store_->finish(succeeded(again, "good"), "good"));
    EXPECT_EQ(**store_->result("a"), "good");
}

TEST_P(JobStoreTest, ReturnsJobsAndCountsTheStart) {
    add(*store_, job_named("a"));
    ASSERT_TRUE(store_->requeue(claim(), true));
    EXPECT_EQ(find("a").status, JobStatus::Queued);
    EXPECT_EQ(claim().starts, 2);
}

TEST_P(JobStoreTest, RequeuesJobsWhoseLeaseHasExpired) {
    open_with(kBrief);
    add(*store_, job_named("a"));
    const Job lost = claim();
    const Job job = claim_again();
    EXPECT_EQ(job.id, "a");
    EXPECT_EQ(job.starts, 2);
    EXPECT_GT(job.claim, lost.claim);
    EXPECT_EQ(store_->renew(lost)->owned, JobStore::Owned::Lost);
    EXPECT_TRUE(store_->requeue(lost, false));
    EXPECT_EQ(*store_->finish(succeeded(lost, "late"), "late"), std::nullopt);
    EXPECT_EQ(find("a").claim, job.claim);
    EXPECT_TRUE(*store_->finish(succeeded(job, "good"), "good"))
        << "the lease has expired, but no other server has claimed the job";
    EXPECT_EQ(**store_->result("a"), "good");
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
}

TEST_P(JobStoreTest, RequeuesRunningJobsAfterARestart) {
    if (!GetParam().outlives_its_server) GTEST_SKIP() << "a store in memory ends with its server";
    open_with(kBrief);
    add(*store_, job_named("a"));
    Job job = claim();
    job.status = JobStatus::Running;
    ASSERT_TRUE(store_->renew(job));
    open_with(kBrief);
    EXPECT_EQ(claim_again().starts, 2);
}

TEST_P(JobStoreTest, ClaimsNoJobThatNeedsTooMuchMemory) {
    Job large = job_named("large");
    large.cost.memory = kMemory + 1;
    add(*store_, large);
    add(*store_, job_named("small"));
    EXPECT_EQ(claim().id, "small");
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_EQ(claim(kMemory + 1).id, "large");
}

TEST_P(JobStoreTest, AlternatesBetweenClients) {
    for (const std::string id : {"a1", "a2", "a3", "b1", "b2"}) {
        Job job = job_named(id);
        job.client = id.substr(0, 1);
        add(*store_, job);
    }
    std::string order;
    for (int i = 0; i < 5; ++i) order += claim().id + ' ';
    EXPECT_EQ(order, "a1 b1 a2 b2 a3 ");
}

TEST_P(JobStoreTest, ChargesTheProcessorTimeOfJobs) {
    for (const std::string id : {"a1", "a2", "b1", "b2", "b3"}) {
        Job job = job_named(id);
        job.client = id.substr(0, 1);
        add(*store_, job);
    }
    Job first = succeeded(claim(), "");
    EXPECT_EQ(first.id, "a1");
    first.used = 60;
    ASSERT_TRUE(*store_->finish(first, ""));
    Job late = job_named("c1");
    late.client = "a";
    add(*store_, late);
    std::string order;
    for (int i = 0; i < 5; ++i) order += claim().id + ' ';
    EXPECT_EQ(order, "b1 b2 b3 a2 c1 ");
}

TEST_P(JobStoreTest, RefusesJobsIfTheQueueIsFull) {
    open_with({.waiting = 2});
    const auto add_for = [this](const std::string& client, const std::string& id) {
        Job job = job_named(id);
        job.client = client;
        return *store_->add(job, kComputeRequest);
    };
    EXPECT_EQ(add_for("a", "1"), JobStore::Added::Accepted);
    EXPECT_FALSE(*store_->is_full("a"));
    EXPECT_EQ(add_for("a", "2"), JobStore::Added::Accepted);
    EXPECT_TRUE(*store_->is_full("a"));
    EXPECT_EQ(add_for("a", "3"), JobStore::Added::QueueFull);
    EXPECT_FALSE(is_there("3"));
    EXPECT_FALSE(*store_->is_full("b"));
    EXPECT_EQ(add_for("b", "4"), JobStore::Added::Accepted) << "a client without a waiting job is admitted";
    EXPECT_EQ(add_for("b", "5"), JobStore::Added::QueueFull);
    EXPECT_EQ(add_for("c", "6"), JobStore::Added::Accepted);
    EXPECT_EQ(add_for("d", "7"), JobStore::Added::QueueFull) << "the queue has twice the capacity";
    EXPECT_TRUE(*store_->cancel("4"));
    EXPECT_FALSE(*store_->is_full("b"));
    EXPECT_TRUE(*store_->remove("6"));
    EXPECT_EQ(store_->load()->queued, 2u);
}

TEST_P(JobStoreTest, DropsTheOldestResultsAtTheByteLimit) {
    const std::string result(4000, 'x');
    constexpr std::size_t kCapacity = 16'000;  // bytes of three results and a request
    open_with({.bytes = kCapacity});
    for (const char* id : {"oldest", "older", "newest"}) add_finished(*store_, id, result);
    EXPECT_TRUE(*store_->result("oldest"));
    add(*store_, job_named("a"));
    EXPECT_TRUE(find("oldest").dropped);
    EXPECT_EQ(*store_->result("oldest"), std::nullopt);
    EXPECT_FALSE(find("older").dropped);
    const std::string large(6000, 'x');
    EXPECT_TRUE(*store_->finish(succeeded(claim(), large), large));
    EXPECT_TRUE(find("older").dropped);
    EXPECT_FALSE(find("newest").dropped);
    EXPECT_LE(bytes(), kCapacity);
}

TEST_P(JobStoreTest, RefusesJobsAndResultsBeyondTheByteLimit) {
    const std::size_t one = JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest));
    open_with({.bytes = 2 * one});
    add_finished(*store_, "done", "result");
    add(*store_, job_named("a"));
    add(*store_, job_named("b"));
    EXPECT_FALSE(is_there("done")) << "the oldest result must be dropped to free space";
    Job refused = job_named("c");
    EXPECT_EQ(*store_->add(refused, kComputeRequest), JobStore::Added::StoreFull);
    EXPECT_FALSE(is_there("c"));
    Job job = claim();
    const std::string large(2 * one, 'x');
    const auto finished = store_->finish(succeeded(job, large), large);
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().code, ErrorCode::LimitExceeded);
    job.status = JobStatus::Failed;
    EXPECT_TRUE(*store_->finish(job, {})) << "a job without a result needs no space";
}

TEST_P(JobStoreTest, CancelsUnfinishedJobs) {
    add(*store_, job_named("runs"));
    add(*store_, job_named("waits"));
    Job job = claim();
    job.status = JobStatus::Running;
    job.progress = {0.25, 2, 0.1};
    ASSERT_TRUE(store_->renew(job));
    for (const char* id : {"runs", "waits"}) {
        const auto cancelled = store_->cancel(id);
        ASSERT_TRUE(cancelled && *cancelled);
        EXPECT_EQ((*cancelled)->status, JobStatus::Cancelled);
        const Job found = find(id);
        EXPECT_EQ(found.status, JobStatus::Cancelled);
        EXPECT_EQ(found.finished, (*cancelled)->finished);
        EXPECT_EQ(*store_->request(id), std::nullopt);
        EXPECT_EQ(*store_->cancel(id), std::nullopt);
    }
    EXPECT_EQ(find("runs").progress.fraction, 0.25);
    EXPECT_EQ(store_->renew(job)->owned, JobStore::Owned::Cancelled);
    EXPECT_EQ(*store_->finish(succeeded(job, "late"), "late"), std::nullopt);
    EXPECT_EQ(find("runs").status, JobStatus::Cancelled);
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_EQ(bytes(), 2 * JobStore::bytes_of_job(0));
    EXPECT_TRUE(*store_->remove("runs"));
    EXPECT_TRUE(*store_->remove("waits"));
    EXPECT_EQ(bytes(), 0u);
}

TEST_P(JobStoreTest, ClaimsWebhooksOfFinishedJobs) {
    constexpr std::chrono::hours kLease{1};
    Job job = job_named("a");
    job.callback = "https://example.org/hook?a=b";
    add(*store_, job);
    add(*store_, job_named("without a webhook"));
    EXPECT_EQ(*store_->claim_webhook(kBrief.lease), std::nullopt) << "the job has not ended";
    if (GetParam().outlives_its_server) open_with({});
    for (const auto& result : {"first", "second"}) ASSERT_TRUE(*store_->finish(succeeded(claim(), result), result));
    if (GetParam().outlives_its_server) open_with({});

    const auto webhook = *store_->claim_webhook(kLease);
    ASSERT_TRUE(webhook);
    EXPECT_EQ(webhook->job.callback, job.callback);
    EXPECT_EQ(webhook->attempts, 1);
    EXPECT_EQ(status_json(webhook->job), status_json(find("a")));
    EXPECT_EQ(*store_->claim_webhook(kLease), std::nullopt) << "each webhook is claimed once";
    ASSERT_TRUE(store_->settle_webhook("a", std::chrono::milliseconds(0)));
    EXPECT_EQ((*store_->claim_webhook(std::chrono::milliseconds(0)))->attempts, 2);
    EXPECT_EQ((*store_->claim_webhook(kLease))->attempts, 3) << "a lost server does not settle its webhooks";
    ASSERT_TRUE(store_->settle_webhook("a", std::nullopt));
    EXPECT_EQ(*store_->claim_webhook(kLease), std::nullopt);
    EXPECT_EQ(find("a").status, JobStatus::Succeeded);
}

TEST_P(JobStoreTest, ClaimsWebhooksOfCancelledJobs) {
    Job job = job_named("a");
    job.callback = "https://example.org/hook";
    add(*store_, job);
    ASSERT_TRUE(*store_->cancel("a"));
    EXPECT_EQ((*store_->claim_webhook(std::chrono::milliseconds(0)))->job.status, JobStatus::Cancelled);
    EXPECT_TRUE(*store_->remove("a"));
    EXPECT_EQ(*store_->claim_webhook(std::chrono::milliseconds(0)), std::nullopt);
}

TEST_P(JobStoreTest, RemovesUnfinishedJobs) {
    add(*store_, job_named("runs"));
    add(*store_, job_named("waits"));
    const Job job = claim();
    EXPECT_TRUE(*store_->remove("runs"));
    EXPECT_TRUE(*store_->remove("waits"));
    EXPECT_EQ(store_->renew(job)->owned, JobStore::Owned::Lost);
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    EXPECT_EQ(store_->load()->queued + store_->load()->running + bytes(), 0u);
}

TEST_P(JobStoreTest, RemovesExpiredJobs) {
    add_finished(*store_, "a", "result");
    EXPECT_FALSE(*store_->remove_expired());
    EXPECT_TRUE(is_there("a"));
    open_with({.ttl = std::chrono::milliseconds(1)});
    if (!GetParam().outlives_its_server) add_finished(*store_, "a", "result");
    add(*store_, job_named("waits"));
    ASSERT_TRUE(test::wait_until("the expiry of a job", [&] { return !is_there("a"); }));
    EXPECT_FALSE(*store_->remove_expired());
    EXPECT_TRUE(is_there("waits"));
    EXPECT_EQ(bytes(), JobStore::bytes_of_job(JobStore::bytes_of(kComputeRequest)));
}

TEST_P(JobStoreTest, RemovesExpiredJobsInBatches) {
    open_with({.ttl = std::chrono::milliseconds(1)});
    for (int i = 0; i < 150; ++i) add_finished(*store_, std::to_string(i), "result");
    ASSERT_TRUE(test::wait_until("the expiry of the last job", [&] { return !is_there("149"); }));
    EXPECT_TRUE(*store_->remove_expired());
    EXPECT_GT(bytes(), 0u);
    EXPECT_FALSE(*store_->remove_expired());
    EXPECT_EQ(bytes(), 0u);
}

TEST_P(JobStoreTest, NotifiesTheListener) {
    Heard heard;
    listen(*store_, heard);
    add(*store_, job_named("a"));
    EXPECT_TRUE(heard.has("work"));
    Job job = claim();
    job.status = JobStatus::Running;
    ASSERT_TRUE(store_->renew(job));
    EXPECT_TRUE(heard.has("changed a"));
    ASSERT_TRUE(*store_->cancel("a"));
    EXPECT_TRUE(heard.has("stop a"));
    store_->listen(nullptr);
}

TEST_P(JobStoreTest, IsSharedByAllServers) {
    if (!store_->is_shared()) GTEST_SKIP() << "this store belongs to one server";
    const auto other = place_->open({});
    Heard heard;
    listen(*other, heard);
    add(*store_, job_named("a"));
    EXPECT_TRUE(heard.has("work"));
    EXPECT_EQ((*other->find("a"))->status, JobStatus::Queued);
    Job job = **other->claim(kMemory);
    EXPECT_EQ(*store_->claim(kMemory), std::nullopt);
    job.status = JobStatus::Running;
    job.progress = {0.5, 3, {}};
    ASSERT_TRUE(store_->renew(job)) << "a claim is identified by its number, not by the server";
    EXPECT_TRUE(heard.has("changed a"));
    EXPECT_EQ(find("a").progress.iteration, 3);
    EXPECT_TRUE(*store_->cancel("a"));
    EXPECT_TRUE(heard.has("stop a"));
    EXPECT_EQ(other->renew(job)->owned, JobStore::Owned::Cancelled);
    other->listen(nullptr);
}

TEST_P(JobStoreTest, IsThreadSafe) {
    constexpr int kThreads = 4;
    constexpr int kJobs = 25;
    const auto work = [this](int thread) {
        for (int i = 0; i < kJobs; ++i) {
            const std::string id = std::to_string(thread) + "-" + std::to_string(i);
            add(*store_, job_named(id));
            const Job job = claim();  // possibly a job that another thread added
            ASSERT_TRUE(*store_->finish(succeeded(job, job.id), job.id));
            EXPECT_EQ(**store_->result(job.id), job.id);
            if (i % 2 == 0) {
                EXPECT_TRUE(*store_->remove(job.id));
            }
        }
    };
    {
        std::vector<std::jthread> threads;
        for (int thread = 0; thread < kThreads; ++thread) threads.emplace_back(work, thread);
    }
    const auto remaining = kThreads * (kJobs / 2);
    EXPECT_EQ(store_->load()->queued + store_->load()->running, 0u);
    EXPECT_GT(bytes(), remaining * JobStore::bytes_of_job(0));
    EXPECT_LT(bytes(), remaining * JobStore::bytes_of_job(10));
}

}  // namespace
}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <string>

#include "server/jobs/sqlite_job_store.h"
#include "tests/server/compute_in_process.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;

const std::string kAlice = "alice";
const std::string kBob = "bob";

ComputeRequest sample(const std::string& members) {
    return {"/sample", "", "", "", R"({"domain":{"type":"torus","width":1,"height":1},)" + members + "}"};
}

const ComputeRequest kShort = sample(R"("sites":50)");

/// A request whose computation takes longer than any test, unless it is stopped.
const ComputeRequest kEndless = sample(R"("sites":2000,"iterations":1000,"passes":100)");

/// A request whose answer is the same on every run.
const ComputeRequest kAnalysis{"/analyze", "", "", "", R"({"points":[[0,0],[0.5,0.5],[0.2,0.7]]})"};

/// A store that cannot be reached at the first call of request().
class AwayOnce : public JobStore {
public:
    Result<bool> is_full(std::string_view client) override { return store_->is_full(client); }
    Result<Added> add(Job& job, const ComputeRequest& request) override { return store_->add(job, request); }
    Result<std::optional<Job>> claim(std::size_t memory) override { return store_->claim(memory); }
    Result<std::optional<ComputeRequest>> request(const std::string& id) override {
        if (away_.exchange(false)) return failure(ErrorCode::Stopped, "away");
        return store_->request(id);
    }
    Result<Renewal> renew(const Job& job) override { return store_->renew(job); }
    Result<void> requeue(const Job& job, bool counted) override { return store_->requeue(job, counted); }
    Result<bool> append_piece(const Job& job, const StoredPart& before, std::string_view piece) override {
        return store_->append_piece(job, before, piece);
    }
    Result<std::optional<Time>> finish(const Job& job, std::string_view result, const StoredPart& before) override {
        return store_->finish(job, result, before);
    }
    Result<std::optional<Job>> cancel(const std::string& id) override { return store_->cancel(id); }
    Result<std::optional<Webhook>> claim_webhook(std::chrono::milliseconds lease) override {
        return store_->claim_webhook(lease);
    }
    Result<void> settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) override {
        return store_->settle_webhook(id, pause);
    }
    Result<bool> remove(const std::string& id) override { return store_->remove(id); }
    Result<std::optional<Job>> find(const std::string& id) override { return store_->find(id); }
    Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) override {
        return store_->piece(id, number);
    }
    Result<bool> remove_expired() override { return store_->remove_expired(); }
    Result<Load> load() override { return store_->load(); }
    void listen(JobListener* listener) override { store_->listen(listener); }

private:
    std::unique_ptr<JobStore> store_ = *SqliteJobStore::open("");
    std::atomic<bool> away_ = true;
};

/// A store whose clock is a minute ahead, and which fails to record the starts of jobs.
class Ahead : public AwayOnce {
public:
    Result<std::optional<Job>> claim(std::size_t memory) override {
        auto job = AwayOnce::claim(memory);
        if (job && *job) (*job)->created += std::chrono::minutes(1);
        return job;
    }
    Result<Renewal> renew(const Job&) override { return failure(ErrorCode::Stopped, "away"); }
};

class JobsTest : public testing::Test {
protected:
    void start(JobLimits limits = {}, bool survives = false) {
        make_store(limits);
        jobs_.emplace(limits, *store_, survives, pool_, compute_, [](const JobEnd&) {});
        jobs_->start();
    }

    /// Creates the store, if there is none.
    void make_store(const JobLimits& limits) {
        if (!store_) store_ = *SqliteJobStore::open("", limits);
    }

    std::string submit(const ComputeRequest& request, const std::string& owner = kAlice) {
        const auto job = try_to_submit(request, owner);
        EXPECT_TRUE(job) << job.error().error.message;
        return job ? job->id : "";
    }

    tl::expected<Job, Problem> try_to_submit(const ComputeRequest& request, const std::string& owner = kAlice) {
        Job job;
        job.owner = owner;
        job.client = owner;
        job.cost = {1000, 1};
        return jobs_->accept(std::move(job), request);
    }

    /// Watches a job until a condition holds for it.
    template <class Condition>
    Job follow(const std::string& id, const std::string& what, Condition condition) {
        auto watch = jobs_->watch(id, kAlice);
        Job job;
        bool holds = false;
        EXPECT_TRUE(test::wait_until(what, [&] {
            const auto next = watch->next(JobService::Clock::now() + test::kPatience);
            if (next) job = *next;
            holds = next && condition(job);
            return holds || !next || is_finished(job.status);
        }));
        EXPECT_TRUE(holds) << "waited for " << what << "; last status: " << name_of(job.status);
        return job;
    }

    Job wait_for_end(const std::string& id) {
        return follow(id, "the end of a job", [](const Job& job) { return is_finished(job.status); });
    }

    void wait_until_running(const std::string& id) {
        follow(id, "the first iteration of a job", [](const Job& job) { return job.progress.variation.has_value(); });
    }

    int status_of(const std::string& id, const std::string& owner = kAlice) {
        const auto found = jobs_->find(id, owner);
        return found ? 200 : found.error().status;
    }

    std::size_t stored_bytes() { return jobs_->load()->bytes; }

    std::unique_ptr<JobStore> store_;
    WorkerPool pool_{1, 0};
    Compute compute_ = test::compute_in_process();
    std::optional<JobService> jobs_;
};

TEST_F(JobsTest, ReturnTheSynchronousAnswer) {
    start();
    api::Timings timings;
    const auto expected = compute_(kAnalysis, {}, {}, timings);
    const std::string id = submit(kAnalysis);
    EXPECT_EQ(id.size(), 32u);
    const Job job = wait_for_end(id);
    EXPECT_EQ(job.status, JobStatus::Succeeded);
    EXPECT_EQ(job.progress.fraction, 1);
    EXPECT_EQ(job.media_type, "application/json");
    EXPECT_EQ(*jobs_->result(id), expected->body);
    EXPECT_LE(job.created, job.started);
    EXPECT_LE(job.started, job.finished);
    EXPECT_EQ(jobs_->find(id, kAlice)->status, JobStatus::Succeeded);
}

TEST_F(JobsTest, ReportEveryProgressStep) {
    make_store({});
    jobs_.emplace(JobLimits{}, *store_, false, pool_, compute_, [](const JobEnd&) {});
    const std::string id = submit(sample(R"("sites":500,"iterations":7)"));
    auto watch = jobs_->watch(id, kAlice);
    const auto never = [] { return JobService::Clock::now() + std::chrono::minutes(2); };
    EXPECT_EQ(watch->next(never())->status, JobStatus::Queued);
    EXPECT_EQ(watch->next(JobService::Clock::now()), std::nullopt);
    jobs_->start();
    double done = 0;
    auto job = watch->next(never());
    for (int step = 0; job->status == JobStatus::Running; job = watch->next(never()), ++step) {
        EXPECT_EQ(job->progress.iteration, std::min(step, 7))
            << "the polish follows the iterations and does not change their number";
        EXPECT_GT(job->progress.fraction, done);
        EXPECT_GT(job->progress.variation, 0);
        done = job->progress.fraction;
    }
    EXPECT_GT(done, 0.9);
    EXPECT_LT(done, 1);
    EXPECT_EQ(job->status, JobStatus::Succeeded);
    EXPECT_EQ(watch->next(JobService::Clock::now()), std::nullopt);
    EXPECT_EQ(jobs_->watch(id, kAlice)->next(never())->status, JobStatus::Succeeded)
        << "late watchers must get the current state at once";
}

TEST_F(JobsTest, FailLikeTheSynchronousAnswer) {
    start();
    const ComputeRequest crossing{"/sample", "", "", "",
                                  R"({"sites":9,"polygon":[[0,0],[1,1],[1,0],[0,1]],"invalid":"reject"})"};
    const Job job = wait_for_end(submit(crossing));
    EXPECT_EQ(job.status, JobStatus::Failed);
    ASSERT_TRUE(job.failure);
    EXPECT_EQ(job.failure->status, 422);
    EXPECT_EQ(job.failure->error.field, "/polygon/2");
}

TEST_F(JobsTest, AreCancelledWhileTheyRunOrWait) {
    start();
    const std::string running = submit(kEndless);
    const std::string waiting = submit(kEndless);
    wait_until_running(running);
    EXPECT_EQ(jobs_->load()->running, 1u);
    EXPECT_EQ(jobs_->load()->queued, 1u);
    EXPECT_TRUE(jobs_->remove(waiting, kAlice));
    EXPECT_EQ(jobs_->find(waiting, kAlice)->status, JobStatus::Cancelled);
    EXPECT_TRUE(jobs_->remove(running, kAlice));
    EXPECT_EQ(jobs_->find(running, kAlice)->status, JobStatus::Cancelled);
    EXPECT_EQ(wait_for_end(submit(kShort)).status, JobStatus::Succeeded) << "the worker must be free again";
    EXPECT_TRUE(jobs_->remove(running, kAlice));
    EXPECT_EQ(status_of(running), 404);
}

TEST_F(JobsTest, AreVisibleToTheirOwnerOnly) {
    start();
    const std::string id = submit(kShort);
    EXPECT_EQ(status_of(id, kBob), 404);
    wait_for_end(id);
    EXPECT_EQ(status_of(id, kBob), 404);
    EXPECT_EQ(status_of(id, ""), 404);
    EXPECT_EQ(jobs_->remove(id, kBob).error().status, 404);
    EXPECT_EQ(jobs_->watch(id, kBob).error().status, 404);
    EXPECT_EQ(status_of(id), 200);
}

TEST_F(JobsTest, FailAtTheirTimeout) {
    start({.timeout = milliseconds(1)});
    const Job late = wait_for_end(submit(kEndless));
    EXPECT_EQ(late.status, JobStatus::Failed);
    EXPECT_EQ(late.failure->status, 504);
}

TEST_F(JobsTest, ReturnPartialResultsAtTheirTimeoutIfAllowed) {
    start({.timeout = milliseconds(500)});
    const Job job =
        wait_for_end(submit(sample(R"("sites":2000,"iterations":1000,"passes":100,"on_deadline":"partial")")));
    EXPECT_EQ(job.status, JobStatus::Succeeded);
    EXPECT_TRUE(job.partial);
}

TEST_F(JobsTest, AreRefusedIfTheQueueIsFull) {
    start({.waiting = 1});
    const std::string running = submit(kEndless);
    wait_until_running(running);
    submit(kEndless);
    EXPECT_TRUE(jobs_->is_full(kAlice));
    const auto refused = try_to_submit(kEndless);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().status, 429);
    EXPECT_EQ(refused.error().headers.at(0).name, "Retry-After");
    EXPECT_TRUE(try_to_submit(kEndless, kBob)) << "a client without a waiting job is admitted";
    EXPECT_FALSE(try_to_submit(kEndless, kBob));
}

TEST_F(JobsTest, DropTheOldestResultsAtTheByteLimit) {
    start({.bytes = 13'000});
    const ComputeRequest request = sample(R"("sites":100)");  // an answer of about 4 kB
    const std::string first = submit(request);
    wait_for_end(first);
    const std::string second = submit(request);
    wait_for_end(second);
    EXPECT_TRUE(jobs_->result(first));
    const std::string third = submit(request);
    wait_for_end(third);
    EXPECT_EQ(jobs_->find(first, kAlice)->status, JobStatus::Succeeded);
    EXPECT_EQ(jobs_->result(first).error().status, 410);
    EXPECT_TRUE(jobs_->result(second));
    EXPECT_TRUE(jobs_->result(third));
    EXPECT_LE(stored_bytes(), 13'000u);
}

TEST_F(JobsTest, FailIfTheResultExceedsTheByteLimit) {
    start({.bytes = 13'000});
    const Job job = wait_for_end(submit(sample(R"("sites":1000)")));
    EXPECT_EQ(job.status, JobStatus::Failed);
    EXPECT_EQ(job.failure->status, 507);
    EXPECT_EQ(jobs_->find(job.id, kAlice)->failure->status, 507);
}

TEST_F(JobsTest, AreRefusedIfTheyExceedTheByteLimit) {
    start({.bytes = 2'000});
    EXPECT_EQ(try_to_submit(sample("\"sites\":5" + std::string(2'000, ' '))).error().status, 413);
}

TEST_F(JobsTest, AreRemovedAfterTheirTtl) {
    start({.ttl = milliseconds(1)});
    const std::string id = submit(kShort);
    ASSERT_TRUE(test::wait_until("the expiry of a job", [&] { return status_of(id) != 200; }));
    EXPECT_EQ(status_of(id), 404);
    EXPECT_TRUE(test::wait_until("the deletion of an expired job", [&] { return stored_bytes() == 0; }));
}

TEST_F(JobsTest, EndTheirWatchesWhenRemoved) {
    start();
    const std::string running = submit(kEndless);
    wait_until_running(running);
    const std::string lost = submit(kShort);
    auto watch = *jobs_->watch(lost, kAlice);
    EXPECT_TRUE(watch.next(JobService::Clock::now()));
    ASSERT_TRUE(*store_->remove(lost)) << "removing a job sends no notification";
    EXPECT_FALSE(watch.next(JobService::Clock::now()));
    EXPECT_FALSE(watch.is_over());
    watch.look_again();
    EXPECT_TRUE(test::wait_until("the end of a watch",
                                 [&] { return !watch.next(JobService::Clock::now() + test::kPatience); }));
    EXPECT_TRUE(watch.is_over());
}

TEST_F(JobsTest, FailOnDrainIfTheyAreNotKept) {
    start();
    const std::string running = submit(kEndless);
    wait_until_running(running);
    const std::string waiting = submit(kEndless);
    jobs_->drain();
    for (const auto& id : {running, waiting}) {
        EXPECT_EQ(jobs_->find(id, kAlice)->status, JobStatus::Failed);
        EXPECT_EQ(jobs_->find(id, kAlice)->failure->status, 503);
    }
    EXPECT_EQ(try_to_submit(kShort).error().status, 503);
}

TEST_F(JobsTest, ContinueOnTheNextServer) {
    start({}, true);
    const std::string running = submit(sample(R"("sites":2000,"iterations":100)"));
    const std::string waiting = submit(kShort);
    wait_until_running(running);
    jobs_->drain();
    const std::string late = submit(kShort);
    jobs_.reset();
    for (const auto& id : {running, waiting, late}) {
        const Job job = **store_->find(id);
        EXPECT_EQ(job.status, JobStatus::Queued);
        EXPECT_EQ(job.starts, 0);
    }
    start({}, true);
    EXPECT_EQ(wait_for_end(running).status, JobStatus::Succeeded);
    EXPECT_EQ(wait_for_end(waiting).status, JobStatus::Succeeded);
}

TEST_F(JobsTest, FailAfterThreeInterruptedStarts) {
    constexpr JobLimits kBrief{.lease = milliseconds(1)};
    make_store(kBrief);
    Job job;
    job.id = "fatal";
    job.owner = kAlice;
    ASSERT_TRUE(store_->add(job, kShort));
    for (int start = 1; start <= 3; ++start) {
        std::optional<Job> claimed;
        ASSERT_TRUE(test::wait_until("an expired lease", [&] {
            claimed = *store_->claim(1000);
            return claimed.has_value();
        }));
        EXPECT_EQ(claimed->starts, start);
    }
    start(kBrief, true);
    const Job found = wait_for_end("fatal");
    EXPECT_EQ(found.status, JobStatus::Failed);
    EXPECT_EQ(found.failure->status, 500);
    EXPECT_EQ(jobs_->counts().repeated, 1u);
}

/// Returns a computation that fails a number of times for lack of a decoder, and then succeeds.
Compute failing(int times) {
    return [remaining = std::make_shared<std::atomic<int>>(times), compute = test::compute_in_process()](
               const auto& request, const auto& delivery, const auto& control, auto& timings) -> Result<api::Answer> {
        if ((*remaining)-- > 0) return failure(ErrorCode::Unavailable, "no decoder");
        return compute(request, delivery, control, timings);
    };
}

TEST_F(JobsTest, RunAgainAfterATemporaryFault) {
    compute_ = failing(2);
    start();
    EXPECT_EQ(wait_for_end(submit(kShort)).status, JobStatus::Succeeded);
    EXPECT_EQ(jobs_->counts().repeated, 2u);
}

TEST_F(JobsTest, FailAfterThreeTemporaryFaults) {
    compute_ = failing(3);
    start();
    const Job job = wait_for_end(submit(kShort));
    EXPECT_EQ(job.status, JobStatus::Failed);
    ASSERT_TRUE(job.failure);
    EXPECT_EQ(job.failure->status, 503);
    EXPECT_EQ(job.failure->error.message, "no decoder");
}

TEST_F(JobsTest, NeverWaitANegativeTime) {
    store_ = std::make_unique<Ahead>();
    std::promise<double> waited;
    jobs_.emplace(JobLimits{}, *store_, false, pool_, compute_,
                  [&](const JobEnd& end) { waited.set_value(end.stages.queue); });
    jobs_->start();
    submit(kAnalysis);
    auto queued = waited.get_future();
    ASSERT_TRUE(test::wait_for("the end of a job", queued));
    EXPECT_GE(queued.get(), 0);
    jobs_.reset();  // before the promise is destroyed
}

TEST_F(JobsTest, SurviveAnUnreachableStore) {
    store_ = std::make_unique<AwayOnce>();
    start({}, true);
    const std::string id = submit(kShort);
    EXPECT_EQ(wait_for_end(id).status, JobStatus::Succeeded);
    EXPECT_EQ(jobs_->counts().repeated, 0u);
}

TEST(StatusJson, WritesNullForMissingValues) {
    Job job;
    job.id = "0123";
    job.created = Time(milliseconds(1'700'000'000'007));
    EXPECT_EQ(status_json(job), R"({"id":"0123","status":"queued","progress":0.0,"iteration":0,"variation":null,)"
                                R"("created":"2023-11-14T22:13:20.007Z","started":null,"finished":null,"error":null})");
    job.failure = Problem{504, {ErrorCode::Stopped, "late", {}}};
    EXPECT_TRUE(status_json(job).ends_with(
        R"("error":{"type":"about:blank","title":"Gateway Timeout","status":504,"detail":"late","instance":"/jobs/0123"}})"))
        << status_json(job);
}

}  // namespace
}  // namespace ccdt::server

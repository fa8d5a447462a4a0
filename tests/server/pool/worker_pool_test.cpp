// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/worker_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <future>
#include <latch>
#include <stdexcept>
#include <string>

#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

const std::string kClient = "client";
constexpr bool kMayBeShort = false;
constexpr api::Cost kShortJob{0, WorkerPool::kShort};
constexpr api::Cost kLongJob{0, 1};

/// Makes a job that runs until open() is called.
class Gate {
public:
    WorkerPool::Job job() {
        return [this](const std::stop_token&) {
            started_.set_value();
            EXPECT_TRUE(test::wait_for("the call of open()", opened_));
        };
    }
    void wait_until_started() { ASSERT_TRUE(test::wait_for("the start of a job", started_.get_future())); }
    void open() { open_.set_value(); }

private:
    std::promise<void> started_;
    std::promise<void> open_;
    std::shared_future<void> opened_ = open_.get_future().share();
};

testing::AssertionResult wait_for_stop(const std::stop_token& stop) {
    return test::wait_until("a request to stop", [&] { return stop.stop_requested(); });
}

TEST(WorkerPool, RunsEveryJob) {
    std::atomic<int> done = 0;
    WorkerPool pool(3, 100);
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(pool.submit(kClient, [&](const std::stop_token&) { ++done; }));
    pool.drain();
    EXPECT_EQ(done, 100);
}

TEST(WorkerPool, RunsOneJobPerWorkerAtOnce) {
    std::latch all(3);
    WorkerPool pool(3, 0);
    for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(pool.submit(kClient, [&](const std::stop_token&) { all.arrive_and_wait(); }));
    pool.drain();
}

TEST(WorkerPool, ReportsTheNumberOfRunningJobs) {
    Gate first, second;
    std::vector<std::size_t> told;
    WorkerPool pool(2, 0);
    pool.on_change([&](std::size_t running) { told.push_back(running); });
    ASSERT_TRUE(pool.submit(kClient, first.job()));
    first.wait_until_started();
    ASSERT_TRUE(pool.submit(kClient, second.job()));
    second.wait_until_started();
    first.open();
    second.open();
    pool.drain();
    EXPECT_EQ(told, (std::vector<std::size_t>{1, 2, 1, 0}));
}

TEST(WorkerPool, RefusesJobsIfTheQueueIsFull) {
    Gate gate;
    std::atomic<int> done = 0;
    const auto count = [&](const std::stop_token&) { ++done; };
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit(kClient, gate.job()));
    gate.wait_until_started();
    EXPECT_FALSE(pool.is_full(kClient, kMayBeShort));
    EXPECT_TRUE(pool.submit(kClient, count));
    EXPECT_TRUE(pool.submit(kClient, count));
    EXPECT_TRUE(pool.is_full(kClient, kMayBeShort));
    EXPECT_FALSE(pool.submit(kClient, count));
    gate.open();
    pool.drain();
    EXPECT_EQ(done, 2);
    EXPECT_TRUE(pool.submit(kClient, count));
    pool.drain();
    EXPECT_EQ(done, 3);
}

TEST(WorkerPool, AcceptsJobsUnconditionallyOnRequest) {
    Gate gate;
    std::atomic<int> done = 0;
    const auto count = [&](const std::stop_token&) { ++done; };
    WorkerPool pool(1, 0);
    ASSERT_TRUE(pool.submit(kClient, gate.job()));
    gate.wait_until_started();
    EXPECT_FALSE(pool.submit(kClient, count));
    pool.submit_always(kClient, count, kLongJob);
    const auto withdrawn = pool.submit_always(kClient, count, kLongJob);
    EXPECT_EQ(pool.cancel(withdrawn), WorkerPool::Cancelled::Queued);
    gate.open();
    pool.drain();
    EXPECT_EQ(done, 1);
}

TEST(WorkerPool, KeepsTheOrderOfTheQueue) {
    Gate gate;
    std::string order;
    WorkerPool pool(1, 10);
    ASSERT_TRUE(pool.submit(kClient, gate.job()));
    for (const char letter : std::string("abcde"))
        ASSERT_TRUE(pool.submit(kClient, [&order, letter](const std::stop_token&) { order += letter; }));
    gate.open();
    pool.drain();
    EXPECT_EQ(order, "abcde");
}

TEST(WorkerPool, StopsARunningJob) {
    std::promise<void> started;
    WorkerPool pool(1, 0);
    const auto id = pool.submit(kClient, [&](const std::stop_token& stop) {
        started.set_value();
        EXPECT_TRUE(wait_for_stop(stop));
    });
    ASSERT_TRUE(id);
    ASSERT_TRUE(test::wait_for("the start of a job", started.get_future()));
    EXPECT_EQ(pool.cancel(*id), WorkerPool::Cancelled::Running);
    pool.drain();
    EXPECT_EQ(pool.cancel(*id), WorkerPool::Cancelled::Unknown);
}

TEST(WorkerPool, CancelsAWaitingJob) {
    Gate gate;
    bool ran = false;
    WorkerPool pool(1, 1);
    ASSERT_TRUE(pool.submit(kClient, gate.job()));
    gate.wait_until_started();
    const auto id = pool.submit(kClient, [&](const std::stop_token&) { ran = true; });
    ASSERT_TRUE(id);
    EXPECT_TRUE(pool.is_full(kClient, kMayBeShort));
    EXPECT_EQ(pool.cancel(*id), WorkerPool::Cancelled::Queued);
    EXPECT_FALSE(pool.is_full(kClient, kMayBeShort));
    gate.open();
    pool.drain();
    EXPECT_FALSE(ran);
}

TEST(WorkerPool, SurvivesJobsThatThrow) {
    bool ran = false;
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit(kClient, [](const std::stop_token&) { throw std::runtime_error("x"); }));
    ASSERT_TRUE(pool.submit(kClient, [&](const std::stop_token&) { ran = true; }));
    pool.drain();
    EXPECT_TRUE(ran);
}

TEST(WorkerPool, StopsItsJobsWhenDestroyed) {
    std::promise<void> started;
    bool stopped = false;
    {
        WorkerPool pool(1, 1);
        ASSERT_TRUE(pool.submit(kClient, [&](const std::stop_token& stop) {
            started.set_value();
            EXPECT_TRUE(wait_for_stop(stop));
            stopped = true;
        }));
        ASSERT_TRUE(test::wait_for("the start of a job", started.get_future()));
        ASSERT_TRUE(pool.submit(kClient, [](const std::stop_token&) { ADD_FAILURE() << "a dropped job ran"; }));
    }
    EXPECT_TRUE(stopped);
}

TEST(WorkerPool, EstimatesItsBacklog) {
    Gate gate;
    WorkerPool pool(1, 100);
    EXPECT_EQ(pool.backlog(), std::chrono::seconds(1)) << "the minimum, because no job has run and none waits";
    // Runs a job that takes at least 30 ms, according to the clock of the pool.
    ASSERT_TRUE(pool.submit(kClient, [](const std::stop_token&) {
        const auto end = WorkerPool::Clock::now() + std::chrono::milliseconds(30);
        while (WorkerPool::Clock::now() < end) std::this_thread::yield();
    }));
    pool.drain();
    ASSERT_TRUE(pool.submit(kClient, gate.job()));
    gate.wait_until_started();
    for (int i = 0; i < 99; ++i) ASSERT_TRUE(pool.submit(kClient, [](const std::stop_token&) {}));
    EXPECT_GE(pool.backlog(), std::chrono::seconds(3));
    gate.open();
    pool.drain();
}

TEST(WorkerPool, IgnoresJobsWithLentThreadsInItsPace) {
    constexpr std::size_t kWorkers = 4, kWaiting = 40;
    constexpr api::Cost kExpected{0, 100};
    std::array<Gate, kWorkers> gates;
    WorkerPool pool(kWorkers, kWaiting);
    const auto nothing = [](const std::stop_token&) {};
    ASSERT_TRUE(pool.submit(kClient, nothing, kExpected));
    pool.drain();
    for (Gate& gate : gates) {
        ASSERT_TRUE(pool.submit(kClient, gate.job(), kExpected));
        gate.wait_until_started();
    }
    for (std::size_t i = 0; i < kWaiting; ++i) ASSERT_TRUE(pool.submit(kClient, nothing, kExpected));
    EXPECT_NEAR(pool.load().backlog_seconds, (kWaiting + kWorkers) * kExpected.seconds / kWorkers, 50);
    for (Gate& gate : gates) gate.open();
    pool.drain();
}

/// Submits a job for each client while another job runs. Returns the sequence in which the jobs run.
std::string order_of(const std::vector<std::string>& clients) {
    Gate gate;
    std::string order;
    WorkerPool pool(1, 10);
    EXPECT_TRUE(pool.submit("first", gate.job()));
    gate.wait_until_started();
    for (const std::string& client : clients) {
        EXPECT_TRUE(pool.submit(client, [&order, client](WorkerPool::Turn& turn) {
            order += client;
            turn.used = 1;
        }));
    }
    gate.open();
    pool.drain();
    return order;
}

TEST(WorkerPool, AlternatesBetweenClients) {
    EXPECT_EQ(order_of({"a", "a", "a", "b", "c", "b"}), "abcaba");
    EXPECT_EQ(order_of({"a", "b", "b", "a"}), "abba");
    EXPECT_EQ(order_of({"a", "a", "a"}), "aaa");
}

TEST(WorkerPool, GivesNoCreditToIdleClients) {
    Gate first;
    std::string order;
    const auto note = [&order](const std::string& client) {
        return [&order, client](WorkerPool::Turn& turn) {
            order += client;
            turn.used = 1;
        };
    };
    WorkerPool pool(1, 10);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(pool.submit("a", note("a")));
    ASSERT_TRUE(pool.submit("a", first.job()));
    first.wait_until_started();
    for (int i = 0; i < 2; ++i) ASSERT_TRUE(pool.submit("b", note("b")));
    for (int i = 0; i < 2; ++i) ASSERT_TRUE(pool.submit("a", note("a")));
    first.open();
    pool.drain();
    EXPECT_EQ(order, "aaababa");
}

TEST(WorkerPool, AcceptsNewClientsInAFullQueue) {
    Gate gate;
    const auto nothing = [](const std::stop_token&) {};
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit("a", gate.job()));
    gate.wait_until_started();
    EXPECT_TRUE(pool.submit("a", nothing));
    EXPECT_TRUE(pool.submit("a", nothing));
    EXPECT_TRUE(pool.is_full("a", kMayBeShort));
    EXPECT_FALSE(pool.submit("a", nothing));
    EXPECT_FALSE(pool.is_full("b", kMayBeShort));
    EXPECT_TRUE(pool.submit("b", nothing));
    EXPECT_FALSE(pool.submit("b", nothing));
    EXPECT_TRUE(pool.submit("c", nothing));
    EXPECT_FALSE(pool.submit("d", nothing));
    gate.open();
    pool.drain();
}

TEST(WorkerPool, AlternatesBetweenClientsByCost) {
    Gate gate;
    std::string order;
    WorkerPool pool(1, 20);
    ASSERT_TRUE(pool.submit("first", gate.job()));
    gate.wait_until_started();
    const auto submit = [&](const std::string& client, double seconds) {
        const auto run = [&order, client, seconds](WorkerPool::Turn& turn) {
            order += client;
            turn.used = seconds;
        };
        EXPECT_TRUE(pool.submit(client, run, {0, seconds}));
    };
    for (int i = 0; i < 3; ++i) submit("a", 3);
    for (int i = 0; i < 7; ++i) submit("b", 1);
    gate.open();
    pool.drain();
    EXPECT_EQ(order, "abbbabbbab");
}

TEST(WorkerPool, RunsShortJobsBeforeLongOnes) {
    Gate gate, longer;
    std::promise<void> done;
    WorkerPool pool(1, 1);
    ASSERT_TRUE(pool.submit("a", gate.job(), kLongJob));
    gate.wait_until_started();
    ASSERT_TRUE(pool.submit("a", longer.job(), kLongJob));
    EXPECT_TRUE(pool.is_full("a", kMayBeShort));
    EXPECT_FALSE(pool.is_full("a"));
    EXPECT_FALSE(pool.submit(
        "a", [](const std::stop_token&) {}, kLongJob));
    ASSERT_TRUE(pool.submit(
        "a", [&](const std::stop_token&) { done.set_value(); }, kShortJob));
    ASSERT_TRUE(test::wait_for("a short job", done.get_future()));
    gate.open();
    longer.open();
    pool.drain();
}

TEST(WorkerPool, LetsLongJobsAdvanceBesideOtherPrograms) {
    const auto nice_of = [](const api::Cost& cost) {
        int nice = 0;
        WorkerPool pool(1, 1);
        pool.submit(
            kClient, [&](const std::stop_token&) { nice = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); },
            cost);
        pool.drain();
        return nice;
    };
    // Each step reduces the share of a processor to about four fifths of that of the step before.
    constexpr double kStep = 0.8, kMinShare = 0.25;
    const double weight = std::pow(kStep, nice_of(kLongJob) - getpriority(PRIO_PROCESS, 0));
    EXPECT_LE(weight, 1) << "long jobs yield to connections and short jobs";
    EXPECT_GT(weight, kMinShare) << "of what another program receives";
}

TEST(WorkerPool, KeepsOneThreadForShortJobs) {
    Gate first, second, shorter;
    std::atomic<bool> ran = false;
    WorkerPool pool(2, 2);
    ASSERT_TRUE(pool.submit("a", first.job(), kLongJob));
    ASSERT_TRUE(pool.submit("b", second.job(), kLongJob));
    first.wait_until_started();
    second.wait_until_started();
    ASSERT_TRUE(pool.submit(
        "c", [&](const std::stop_token&) { ran = true; }, kLongJob));
    ASSERT_TRUE(pool.submit("d", shorter.job(), kShortJob));
    shorter.wait_until_started();
    EXPECT_EQ(pool.load().busy, 3U);
    EXPECT_FALSE(ran);
    for (Gate* gate : {&shorter, &first, &second}) gate->open();
    pool.drain();
    EXPECT_TRUE(ran);
}

/// A short job that runs until the pool stops it or open() is called, and its owner.
class Liar {
public:
    explicit Liar(bool is_displaceable = true) : is_displaceable_(is_displaceable) {}

    void submit_to(WorkerPool& pool) {
        const auto run = [this](const std::stop_token& stop) {
            started_.set_value();
            EXPECT_TRUE(test::wait_until("the end of a job", [&] { return stop.stop_requested() || open_; }));
        };
        ASSERT_TRUE(
            pool.submit("liar", run, kShortJob, [this] { return is_displaceable_ && !displaced_.exchange(true); }));
        ASSERT_TRUE(test::wait_for("the start of a job", started_.get_future()));
    }
    void open() { open_ = true; }
    bool is_displaced() const { return displaced_; }

private:
    const bool is_displaceable_;
    std::promise<void> started_;
    std::atomic<bool> open_ = false;
    std::atomic<bool> displaced_ = false;
};

void run_short_job(WorkerPool& pool) {
    std::promise<void> done;
    ASSERT_TRUE(pool.submit(
        "polite", [&](const std::stop_token&) { done.set_value(); }, kShortJob));
    ASSERT_TRUE(test::wait_for("a short job", done.get_future()));
}

TEST(WorkerPool, RunsShortJobsBesideJobsThatOverrun) {
    Gate longer;
    Liar liar;
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit("a", longer.job(), kLongJob));
    longer.wait_until_started();
    liar.submit_to(pool);
    for (int i = 0; i < 3; ++i) run_short_job(pool);
    EXPECT_TRUE(test::wait_until("two running jobs", [&] { return pool.load().busy == 2; }));
    EXPECT_FALSE(liar.is_displaced());
    liar.open();
    longer.open();
    pool.drain();
}

TEST(WorkerPool, DisplacesTheEarliestOverrunBeyondTheLimit) {
    Gate longer;
    Liar first, second, third;
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit("a", longer.job(), kLongJob));
    longer.wait_until_started();
    for (Liar* liar : {&first, &second, &third}) liar->submit_to(pool);
    run_short_job(pool);
    EXPECT_TRUE(test::wait_until("two displaced jobs", [&] { return first.is_displaced() && second.is_displaced(); }));
    EXPECT_FALSE(third.is_displaced());
    EXPECT_TRUE(test::wait_until("two running jobs", [&] { return pool.load().busy == 2; }));
    third.open();
    longer.open();
    pool.drain();
}

TEST(WorkerPool, DisplacesALaterOverrunIfTheEarliestCannotBeDisplaced) {
    Gate longer;
    Liar first(false), second;
    WorkerPool pool(1, 2);
    ASSERT_TRUE(pool.submit("a", longer.job(), kLongJob));
    longer.wait_until_started();
    for (Liar* liar : {&first, &second}) liar->submit_to(pool);
    run_short_job(pool);
    EXPECT_TRUE(second.is_displaced());
    first.open();
    longer.open();
    pool.drain();
}

TEST(WorkerPool, ChargesTheProcessorTimeOfJobs) {
    Gate gate;
    std::string order;
    WorkerPool pool(1, 20);
    ASSERT_TRUE(pool.submit("first", gate.job()));
    gate.wait_until_started();
    const auto submit = [&](const std::string& client, double used) {
        EXPECT_TRUE(pool.submit(client, [&order, client, used](WorkerPool::Turn& turn) {
            order += client;
            turn.used = used;
        }));
    };
    for (int i = 0; i < 2; ++i) submit("a", 4);
    for (int i = 0; i < 6; ++i) submit("b", 1);
    gate.open();
    pool.drain();
    EXPECT_EQ(order, "abbbbabb") << "jobs of both have the same estimate";
}

TEST(WorkerPool, StartsAJobOnlyWhenItsMemoryIsAvailable) {
    constexpr std::size_t kMemory = 100;
    Gate large;
    std::atomic<std::size_t> seen = 0;
    WorkerPool pool(4, 10, kMemory);
    ASSERT_TRUE(pool.submit("a", large.job(), {60, 1}));
    large.wait_until_started();
    EXPECT_EQ(pool.memory().reserved(), 60U);
    const auto note = [&](const std::stop_token&) {
        seen = std::max<std::size_t>(seen, pool.memory().reserved());
        EXPECT_LE(pool.memory().reserved(), kMemory);
    };
    for (int i = 0; i < 8; ++i) ASSERT_TRUE(pool.submit("b", note, {50, 1}));
    EXPECT_EQ(seen, 0U);
    large.open();
    pool.drain();
    EXPECT_GE(seen, 50U);
    EXPECT_EQ(pool.memory().reserved(), 0U);
}

TEST(WorkerPool, ContinuesWhenMemoryIsReleasedElsewhere) {
    std::promise<void> done;
    WorkerPool pool(1, 10, 100);
    auto lease = std::make_optional(pool.memory().reserve_unconditionally(70));
    ASSERT_TRUE(pool.submit("a", [&](const std::stop_token&) { done.set_value(); }, {50, 1}));
    auto ran = done.get_future();
    EXPECT_EQ(pool.load().waiting, 1U);
    lease.reset();
    ASSERT_TRUE(test::wait_for("a job that needs released memory", ran));
    pool.drain();
}

TEST(MemoryBudget, NeverLendsMoreThanItHas) {
    int told = 0;
    MemoryBudget budget(100);
    budget.on_release([&] { ++told; });
    auto first = budget.reserve(60);
    ASSERT_TRUE(first);
    EXPECT_FALSE(budget.reserve(41));
    EXPECT_FALSE(budget.reserve(std::numeric_limits<std::size_t>::max()));
    auto second = budget.reserve(40);
    ASSERT_TRUE(second);
    {
        const auto held = budget.reserve_unconditionally(10);
        EXPECT_EQ(budget.reserved(), 110U);
        EXPECT_FALSE(budget.reserve(1));
    }
    MemoryBudget::Lease moved = *std::move(first);
    first.reset();
    EXPECT_EQ(budget.reserved(), 100U);
    EXPECT_EQ(told, 1);
    moved = {};
    second.reset();
    EXPECT_EQ(budget.reserved(), 0U);
    EXPECT_EQ(told, 3);
}

}  // namespace
}  // namespace ccdt::server

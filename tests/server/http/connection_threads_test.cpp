// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection_threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <thread>
#include <vector>

#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using namespace std::chrono_literals;

void wait_until_idle(const ConnectionThreads& threads) {
    ASSERT_TRUE(test::wait_until("idle threads", [&] { return threads.counts().busy == 0; }));
}

/// Runs `tasks` tasks at the same time, and waits until their threads are idle.
void run_at_once(ConnectionThreads& threads, int tasks) {
    std::latch all(tasks);
    for (int i = 0; i < tasks; ++i) ASSERT_TRUE(threads.run([&] { all.arrive_and_wait(); }));
    wait_until_idle(threads);
}

TEST(ConnectionThreads, RunAllTasksAtOnce) {
    ConnectionThreads threads(1h);
    run_at_once(threads, 50);
    EXPECT_EQ(threads.counts().idle, 50u);
}

TEST(ConnectionThreads, FinishTheirTasks) {
    for (const auto rest : {std::chrono::milliseconds(0), std::chrono::milliseconds(1h)}) {
        std::atomic<int> done = 0;
        {
            ConnectionThreads threads(rest);
            for (int i = 0; i < 200; ++i) ASSERT_TRUE(threads.run([&] { ++done; }));
        }
        EXPECT_EQ(done, 200);
    }
}

TEST(ConnectionThreads, EndAfterTheIdleTime) {
    ConnectionThreads threads(1ms);
    for (int i = 0; i < 3; ++i) {
        run_at_once(threads, 50);
        ASSERT_TRUE(test::wait_until("the end of idle threads", [&] { return threads.counts().idle == 0; }));
    }
}

TEST(ConnectionThreads, ReuseTheMostRecentlyBusyThread) {
    ConnectionThreads threads(1h);
    run_at_once(threads, 10);
    std::vector<std::thread::id> ids;
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(threads.run([&] { ids.push_back(std::this_thread::get_id()); }));
        wait_until_idle(threads);
    }
    EXPECT_EQ(ids, std::vector(20, ids.front()));
}

}  // namespace
}  // namespace ccdt::server

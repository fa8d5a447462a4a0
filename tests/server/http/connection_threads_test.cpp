#include "server/http/connection_threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace ccdt::server {
namespace {

TEST(ConnectionThreads, LetNoTaskWaitForAnother) {
    constexpr int kTasks = 50;
    std::latch all(kTasks);
    ConnectionThreads threads;
    for (int i = 0; i < kTasks; ++i) ASSERT_TRUE(threads.run([&] { all.arrive_and_wait(); }));
}

TEST(ConnectionThreads, FinishWhatTheyWereGiven) {
    std::atomic<int> done = 0;
    {
        ConnectionThreads threads;
        for (int i = 0; i < 200; ++i) ASSERT_TRUE(threads.run([&] { ++done; }));
    }
    EXPECT_EQ(done, 200);
}

}  // namespace
}  // namespace ccdt::server

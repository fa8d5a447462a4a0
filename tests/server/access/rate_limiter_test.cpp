// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/rate_limiter.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const RateLimiter::Clock::time_point kStart{};

TEST(RateLimiter, AdmitsABurstAndThenASteadyRate) {
    RateLimiter limiter({.per_second = 2, .burst = 3});
    for (int i = 0; i < 3; ++i) EXPECT_EQ(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.take("a", kStart), seconds(1));
    EXPECT_EQ(limiter.take("a", kStart + milliseconds(500)), seconds(0));
    EXPECT_EQ(limiter.take("a", kStart + milliseconds(900)), seconds(1));
    EXPECT_EQ(limiter.take("a", kStart + milliseconds(1000)), seconds(0));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(limiter.take("a", kStart + seconds(100)), seconds(0));
    EXPECT_NE(limiter.take("a", kStart + seconds(100)), seconds(0)) << "a bucket holds no more than the burst";
}

TEST(RateLimiter, ReturnsTheTimeToWait) {
    RateLimiter limiter({.per_second = 0.1, .burst = 1});
    limiter.take("a", kStart);
    EXPECT_EQ(limiter.take("a", kStart), seconds(10));
    EXPECT_EQ(limiter.take("a", kStart + milliseconds(8'500)), seconds(2));
}

TEST(RateLimiter, LimitsEachClientSeparately) {
    RateLimiter limiter({.per_second = 1, .burst = 1});
    EXPECT_EQ(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.take("b", kStart), seconds(0));
    EXPECT_NE(limiter.take("a", kStart), seconds(0));
}

TEST(RateLimiter, IsOffWithoutARate) {
    RateLimiter limiter({.per_second = 0, .burst = 1});
    for (int i = 0; i < 100; ++i) EXPECT_EQ(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.size(), 0u);
}

TEST(RateLimiter, ChangesItsRate) {
    RateLimiter limiter({.per_second = 1, .burst = 5});
    limiter.take("a", kStart);
    limiter.set_rate({.per_second = 0.1, .burst = 2});
    EXPECT_EQ(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.take("a", kStart), seconds(10));
    limiter.set_rate({});
    EXPECT_EQ(limiter.take("a", kStart), seconds(0));
}

TEST(RateLimiter, EvictsTheLeastRecentClient) {
    RateLimiter limiter({.per_second = 0.001, .burst = 1}, 3);
    for (const char* client : {"a", "b", "c", "a", "d"}) limiter.take(client, kStart);
    EXPECT_EQ(limiter.size(), 3u);
    EXPECT_NE(limiter.take("a", kStart), seconds(0));
    EXPECT_EQ(limiter.take("b", kStart), seconds(0)) << "forgotten";
}

}  // namespace
}  // namespace ccdt::server

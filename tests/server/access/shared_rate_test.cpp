// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/shared_rate.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/redis/local_redis.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using std::chrono::seconds;

TEST(SharedRate, IsSharedByAllServers) {
    const test::LocalRedis redis;
    RedisClient here(redis.address());
    RedisClient there(redis.address());
    SharedRate first(here, {.per_second = 0.001, .burst = 3});
    SharedRate second(there, {.per_second = 0.001, .burst = 3});
    EXPECT_EQ(first.take("a"), seconds(0));
    EXPECT_EQ(second.take("a"), seconds(0));
    EXPECT_EQ(first.take("a"), seconds(0));
    const auto refused = second.take("a");
    ASSERT_TRUE(refused);
    EXPECT_GT(*refused, seconds(900));
    EXPECT_LE(*refused, seconds(1000));
    EXPECT_EQ(second.take("b"), seconds(0)) << "each client must have a bucket of its own";
}

TEST(SharedRate, RefillsTokensOverTime) {
    const test::LocalRedis redis;
    RedisClient client(redis.address());
    SharedRate rate(client, {.per_second = 1000, .burst = 1});
    EXPECT_EQ(rate.take("a"), seconds(0));
    ASSERT_TRUE(test::wait_until("a new token", [&] { return rate.take("a") == seconds(0); }));
    const auto remaining = client.run(RedisCommand{"PTTL", "ccdt:1:rate:a"});
    ASSERT_TRUE(remaining);
    EXPECT_LE(remaining->number, 2) << "a full bucket must expire";
}

TEST(SharedRate, RefillsDamagedBuckets) {
    const test::LocalRedis redis;
    RedisClient client(redis.address());
    SharedRate rate(client, {.per_second = 0.001, .burst = 1});
    const std::vector<std::vector<std::string>> damages = {{"SET", "ccdt:1:rate:a", "junk"},
                                                           {"HSET", "ccdt:1:rate:a", "tokens", "junk"},
                                                           {"HSET", "ccdt:1:rate:a", "tokens", "nan"},
                                                           {"HSET", "ccdt:1:rate:a", "filled", "junk"}};
    for (const auto& damage : damages) {
        ASSERT_TRUE(client.run(RedisCommand{"DEL", "ccdt:1:rate:a"}));
        ASSERT_TRUE(client.run(RedisCommand(damage.begin(), damage.end())));
        EXPECT_EQ(rate.take("a"), seconds(0)) << damage.back();
        EXPECT_GT(rate.take("a"), seconds(0));
    }
    EXPECT_EQ(client.counts().damages, damages.size());
    ASSERT_TRUE(client.run(RedisCommand{"HSET", "ccdt:1:rate:a", "tokens", "-1e300"}));
    EXPECT_LE(rate.take("a"), seconds(1000)) << "nobody waits longer than for one token";
}

TEST(SharedRate, ReturnsNothingWithoutRedis) {
    test::LocalRedis redis;
    RedisClient client(redis.address());
    SharedRate rate(client, {.per_second = 1, .burst = 1});
    redis.kill();
    EXPECT_EQ(rate.take("a"), std::nullopt);
}

}  // namespace
}  // namespace ccdt::server

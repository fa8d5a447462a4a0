// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cache/redis_cache.h"

#include <gtest/gtest.h>

#include "server/cache/result_cache.h"
#include "tests/server/redis/local_redis.h"

namespace ccdt::server {
namespace {

api::Answer whole_answer() {
    api::Answer answer;
    answer.body = std::string("\0bytes\xff", 7);
    answer.media_type = "image/png";
    answer.coding = "gzip";
    answer.sites = 7;
    answer.pixels = 9;
    answer.repaired = "[1]";
    answer.warnings = "[2]";
    answer.repeats = false;
    answer.dots = api::DotSize{0.1, 0.7};
    answer.plot = api::PlotSize{0.3};
    return answer;
}

class RedisCacheTest : public testing::Test {
protected:
    test::LocalRedis redis_;
    RedisClient client_{redis_.address()};
    RedisCache cache_{client_};
};

TEST_F(RedisCacheTest, ReturnsStoredAnswers) {
    EXPECT_FALSE(cache_.find("a"));
    const api::Answer answer = whole_answer();
    cache_.store("a", answer);
    const auto found = cache_.find("a");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->body, answer.body);
    EXPECT_EQ(found->media_type, answer.media_type);
    EXPECT_EQ(found->coding, answer.coding);
    EXPECT_EQ(found->sites, answer.sites);
    EXPECT_EQ(found->pixels, answer.pixels);
    EXPECT_EQ(found->repaired, answer.repaired);
    EXPECT_EQ(found->warnings, answer.warnings);
    EXPECT_EQ(found->repeats, answer.repeats);
    ASSERT_TRUE(found->dots);
    EXPECT_EQ(found->dots->radius, answer.dots->radius);
    EXPECT_EQ(found->dots->tone, answer.dots->tone);
    EXPECT_EQ(found->plot->seconds, answer.plot->seconds);
    EXPECT_GT(client_.run(RedisCommand{"TTL", "ccdt:2:answer:a"})->number, 0)
        << "entries must expire, so that Redis evicts them before jobs";
    api::Answer plain;
    plain.body = "plain";
    cache_.store("b", plain);
    EXPECT_FALSE(cache_.find("b")->dots);
    EXPECT_FALSE(cache_.find("b")->plot);
    EXPECT_TRUE(cache_.find("b")->repeats);
}

TEST_F(RedisCacheTest, DoesNotStoreLargeAnswers) {
    api::Answer answer;
    answer.body.assign(RedisCache::kLargest + 1, 'x');
    cache_.store("a", answer);
    EXPECT_FALSE(cache_.find("a"));
}

TEST_F(RedisCacheTest, RemovesDamagedAnswers) {
    for (const char* field : {"body", "media_type", "coding", "sites", "pixels", "repaired", "warnings", "repeats",
                              "radius", "tone", "plot_seconds", "digest"}) {
        cache_.store("a", whole_answer());
        ASSERT_TRUE(client_.run(RedisCommand{"HSET", "ccdt:2:answer:a", field, "junk"}));
        EXPECT_FALSE(cache_.find("a")) << field;
        EXPECT_EQ(client_.run(RedisCommand{"EXISTS", "ccdt:2:answer:a"})->number, 0);
    }
    ASSERT_TRUE(client_.run(RedisCommand{"SET", "ccdt:2:answer:a", "junk"}));
    EXPECT_FALSE(cache_.find("a"));
    cache_.store("a", whole_answer());
    EXPECT_TRUE(cache_.find("a")) << "it must be possible to store it again";
    EXPECT_EQ(client_.counts().damages, 13U);
}

TEST_F(RedisCacheTest, FindsNothingWithoutRedis) {
    cache_.store("a", whole_answer());
    redis_.kill();
    EXPECT_FALSE(cache_.find("a"));
    cache_.store("b", whole_answer());
}

TEST_F(RedisCacheTest, IsQueriedAfterTheLocalCache) {
    ResultCache first(100'000, &client_);
    ResultCache second(100'000, &client_);
    EXPECT_EQ(second.find("a"), nullptr);
    first.store("a", whole_answer());
    ASSERT_NE(second.find("a"), nullptr);
    redis_.kill();
    EXPECT_NE(second.find("a"), nullptr) << "the local cache must have it, too";
    EXPECT_EQ(second.load().hits, 2U);
    EXPECT_EQ(second.load().misses, 1U);
    EXPECT_EQ(second.load().answers, 1U);
    EXPECT_NE(first.find("a"), nullptr);
}

TEST_F(RedisCacheTest, IsQueriedIfTheLocalCacheIsOff) {
    ResultCache first(0, &client_);
    first.store("a", whole_answer());
    EXPECT_NE(ResultCache(0, &client_).find("a"), nullptr);
    EXPECT_EQ(first.load().answers, 0U);
}

}  // namespace
}  // namespace ccdt::server

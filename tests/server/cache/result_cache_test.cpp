// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cache/result_cache.h"

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

constexpr std::size_t kCapacity = 100'000;

api::Answer answer_of(std::string body) {
    api::Answer answer;
    answer.body = std::move(body);
    return answer;
}

TEST(ResultCache, ReturnsStoredAnswers) {
    ResultCache cache(kCapacity);
    EXPECT_EQ(cache.find("a"), nullptr);
    cache.store("a", answer_of("first"));
    cache.store("b", answer_of("second"));
    cache.store("a", answer_of("not this"));
    ASSERT_NE(cache.find("a"), nullptr);
    EXPECT_EQ(cache.find("a")->body, "first");
    EXPECT_EQ(cache.find("b")->body, "second");
    EXPECT_EQ(cache.load().answers, 2U);
    EXPECT_EQ(cache.load().hits, 3U);
    EXPECT_EQ(cache.load().misses, 1U);
}

TEST(ResultCache, EvictsTheLeastRecentlyUsedAnswer) {
    ResultCache cache(kCapacity);
    const std::string large(kCapacity / 5, 'x');
    for (const auto* name : {"a", "b", "c", "d"}) cache.store(name, answer_of(large));
    ASSERT_NE(cache.find("a"), nullptr);
    cache.store("e", answer_of(large));
    EXPECT_EQ(cache.find("b"), nullptr);
    for (const auto* name : {"a", "c", "d", "e"}) EXPECT_NE(cache.find(name), nullptr) << name;
}

TEST(ResultCache, NeverExceedsItsCapacity) {
    ResultCache cache(kCapacity);
    for (int i = 0; i < 1000; ++i) {
        cache.store(std::to_string(i), answer_of(std::string(static_cast<std::size_t>(i), 'x')));
        EXPECT_LE(cache.load().bytes, kCapacity);
    }
    EXPECT_GT(cache.load().bytes, kCapacity / 2);
}

TEST(ResultCache, DoesNotStoreAnswersThatAreTooLarge) {
    ResultCache cache(kCapacity);
    cache.store("small", answer_of("x"));
    cache.store("large", answer_of(std::string(kCapacity / 4, 'x')));
    EXPECT_EQ(cache.find("large"), nullptr);
    EXPECT_NE(cache.find("small"), nullptr);
    ResultCache none(0);
    none.store("a", answer_of(""));
    EXPECT_EQ(none.find("a"), nullptr);
}

TEST(ResultCache, ReturnsAnswersThatOutliveTheCache) {
    auto cache = std::make_unique<ResultCache>(kCapacity);
    cache->store("a", answer_of("kept"));
    const auto answer = cache->find("a");
    cache.reset();
    EXPECT_EQ(answer->body, "kept");
}

TEST(ResultCache, IsThreadSafe) {
    ResultCache cache(kCapacity);
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread) {
        threads.emplace_back([&cache, thread] {
            for (int i = 0; i < 500; ++i) {
                const std::string name = std::to_string((i * (thread + 1)) % 97);
                const auto answer = cache.find(name);
                EXPECT_TRUE(answer == nullptr || answer->body == std::string(2000, name[0]));
                cache.store(name, answer_of(std::string(2000, name[0])));
            }
        });
    }
    threads.clear();
    EXPECT_LE(cache.load().bytes, kCapacity);
}

}  // namespace
}  // namespace ccdt::server

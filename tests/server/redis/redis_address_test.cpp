// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_address.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

TEST(RedisAddress, IsReadFromAUrl) {
    const auto plain = RedisAddress::parse("redis://example.org");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->name(), "example.org:6379");
    EXPECT_FALSE(plain->encrypted);
    EXPECT_EQ(plain->user + plain->password, "");
    EXPECT_EQ(plain->database, 0);
    const auto full = RedisAddress::parse("rediss://al:p%40ss:w@[::1]:7000/3");
    ASSERT_TRUE(full);
    EXPECT_EQ(full->host, "::1");
    EXPECT_EQ(full->port, "7000");
    EXPECT_TRUE(full->encrypted);
    EXPECT_EQ(full->user, "al");
    EXPECT_EQ(full->password, "p@ss:w");
    EXPECT_EQ(full->database, 3);
    EXPECT_EQ(RedisAddress::parse("redis://:secret@/")->password, "secret");
    EXPECT_EQ(RedisAddress::parse("redis://:secret@/")->host, "localhost");
}

TEST(RedisAddress, RefusesInvalidUrlsWithoutShowingThePassword) {
    for (const char* text :
         {"", "example.org", "http://:secret@a", "redis://secret@a", "redis://a:b:secret", "redis://:secret@a:99999",
          "redis://:secret@a/x", "redis://u:secret%4@a", "redis://[::1", "redis://[::1]x:secret"}) {
        const auto address = RedisAddress::parse(text);
        EXPECT_FALSE(address && text[0] != 'r') << text;
        if (!address) {
            EXPECT_EQ(address.error().message.find("secret"), std::string::npos) << text;
        }
    }
    EXPECT_FALSE(RedisAddress::parse("redis://:secret@a:99999"));
    EXPECT_FALSE(RedisAddress::parse("redis://u:secret%4@a"));
}

TEST(RedisAddress, NamesUnsupportedFeatures) {
    for (const char* text : {"redis-sentinel://a:26379/0", "redis+sentinel://a", "rediss+sentinel://a"})
        EXPECT_NE(RedisAddress::parse(text).error().message.find("Sentinel is not supported"), std::string::npos);
    EXPECT_NE(RedisAddress::parse("redis://a:1,b:2").error().message.find("several"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::server

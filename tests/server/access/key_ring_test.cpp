// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/key_ring.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

const std::string kKey = "0123456789abcdef";

TEST(KeyRing, FindsTheOwnerOfAKey) {
    const auto ring =
        KeyRing::parse("# comment\r\n\r\nalice:" + kKey + "A\r\n  bob\t" + kKey + "B  \nbob: " + kKey + ":C");
    ASSERT_TRUE(ring) << ring.error().message;
    EXPECT_EQ(ring->find(kKey + "A"), "alice");
    EXPECT_EQ(ring->find(kKey + "B"), "bob");
    EXPECT_EQ(ring->find(kKey + ":C"), "bob");
}

TEST(KeyRing, FindsNoOwnerOfUnknownKeys) {
    const auto ring = KeyRing::parse("alice:" + kKey);
    ASSERT_TRUE(ring);
    for (const std::string& key : {std::string(), kKey.substr(1), kKey + "x", kKey + std::string(1, '\0'),
                                   "X" + kKey.substr(1), std::string(5000, 'x'), "alice:" + kKey})
        EXPECT_EQ(ring->find(key), std::nullopt) << key;
    EXPECT_EQ(ring->find(kKey + std::string(1000, '\0')), std::nullopt);
}

TEST(KeyRing, ReportsTheInvalidLineButNotTheKey) {
    for (const std::string& line : {std::string("alice"), std::string("alice:short"), "a/b:" + kKey, ":" + kKey,
                                    "alice:" + kKey + " more", "alice:" + std::string(257, 'x'), "bob:" + kKey}) {
        const auto ring = KeyRing::parse("carol:" + kKey + "\n" + line + "\n");
        ASSERT_FALSE(ring) << line;
        EXPECT_TRUE(ring.error().message.starts_with("line 2: ")) << ring.error().message;
        EXPECT_EQ(ring.error().message.find(kKey), std::string::npos);
    }
}

TEST(KeyRing, RequiresAtLeastOneKey) {
    EXPECT_FALSE(KeyRing::parse(""));
    EXPECT_FALSE(KeyRing::parse("# alice:" + kKey));
    EXPECT_FALSE(KeyRing::read("/nowhere"));
}

TEST(BearerKey, IsReadOnlyFromTheBearerScheme) {
    EXPECT_EQ(bearer_key("Bearer abc"), "abc");
    EXPECT_EQ(bearer_key("bearer  abc "), "abc");
    for (const char* header : {"", "Bearer", "Bearer ", "Basic abc", "Bearerabc", "abc"})
        EXPECT_EQ(bearer_key(header), "") << header;
}

}  // namespace
}  // namespace ccdt::server

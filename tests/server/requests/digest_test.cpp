// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/digest.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

/// Compares with test cases 1, 2 and 6 of RFC 4231, in base64.
TEST(Sign, IsHmacSha256) {
    EXPECT_EQ(sign(std::string(20, '\x0b'), "Hi There"), "sDRMYdjbOFNcqK_OrwvxK4gdwgDJgz2nJuk3bC4yz_c");
    EXPECT_EQ(sign("Jefe", "what do ya want for nothing?"), "W9zBRr9gdU5qBCQmCJV1x1oAPwidJzmDnexYuWTsOEM");
    EXPECT_EQ(sign(std::string(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First"),
              "YOQxWR7gtn8Niiaqy_W3f44LxiE3KMUUBUYEDw7jf1Q");
}

TEST(Sign, WritesUrlSafeText) {
    for (int i = 0; i < 100; ++i) {
        const std::string signature = sign("key", std::to_string(i));
        EXPECT_EQ(signature.size(), 43u);
        EXPECT_EQ(signature.find_first_of("+/="), std::string::npos) << signature;
    }
}

}  // namespace
}  // namespace ccdt::server

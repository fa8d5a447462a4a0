// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/cors.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ccdt::server {
namespace {

TEST(AllowsOrigin, AcceptsListedOrigins) {
    const std::vector<std::string> allowed = {"https://a.example", "null"};
    EXPECT_TRUE(allows_origin(allowed, "https://a.example"));
    EXPECT_TRUE(allows_origin(allowed, "null"));
    for (const char* origin : {"", "http://a.example", "https://a.example:443", "http://localhost", "loopback"})
        EXPECT_FALSE(allows_origin(allowed, origin)) << origin;
    EXPECT_TRUE(allows_origin({"*"}, "https://b.example"));
}

TEST(AllowsOrigin, AcceptsLoopbackOrigins) {
    for (const char* origin : {"http://localhost", "https://localhost:5500", "http://app.localhost:1",
                               "http://127.0.0.1:8080", "http://[::1]:3000", "http://[::1]"})
        EXPECT_TRUE(allows_origin({"loopback"}, origin)) << origin;
    for (const char* origin :
         {"", "null", "localhost", "file://localhost", "http://localhost:", "http://localhost:x",
          "http://localhost:1:2", "http://localhost:70000", "http://localhost.example", "http://127.0.0.1.example:80",
          "http://[::1", "http://[", "http://[::2]", "http://", "http://user@localhost", "http://localhost/"})
        EXPECT_FALSE(allows_origin({"loopback"}, origin)) << origin;
}

}  // namespace
}  // namespace ccdt::server

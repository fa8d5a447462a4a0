// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/hosts.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ccdt::server {
namespace {

TEST(IsLoopback, IsTrueOnlyForThisMachine) {
    for (const char* host : {"localhost", "app.localhost", "127.0.0.1", "127.8.9.1", "::1"})
        EXPECT_TRUE(is_loopback(host)) << host;
    for (const char* host : {"", "0.0.0.0", "::", "10.0.0.1", "localhost.example", "notlocalhost", "127.0.0.1.example",
                             "127.1", "unix:/run/socket"})
        EXPECT_FALSE(is_loopback(host)) << host;
}

TEST(AllowsHost, AcceptsLoopbackOnAnyPort) {
    for (const char* authority : {"", "localhost", "LocalHost:80", "localhost.", "localhost.:80", "127.0.0.1",
                                  "127.0.0.1:8080", "127.9.9.9:1", "[::1]", "[::1]:8080", "app.localhost:5500"})
        EXPECT_TRUE(allows_host({"loopback"}, authority)) << authority;
    for (const char* authority : {"evil.example",
                                  "evil.example:8080",
                                  "127.0.0.1.evil.example",
                                  "localhost.evil.example",
                                  "loopback",
                                  "loopback:80",
                                  "::1",
                                  "[::1",
                                  "[::2]",
                                  "0.0.0.0",
                                  "10.0.0.1",
                                  ":80",
                                  ".",
                                  "localhost:",
                                  "localhost:x",
                                  "localhost:70000",
                                  "localhost:80:80",
                                  "localhost..",
                                  "2130706433",
                                  "0x7f.1"})
        EXPECT_FALSE(allows_host({"loopback"}, authority)) << authority;
}

TEST(AllowsHost, AcceptsListedNames) {
    const std::vector<std::string> allowed = {"dots.example", "10.0.0.1", "fd00::1"};
    for (const char* authority : {"dots.example", "Dots.Example:443", "dots.example.", "10.0.0.1:80", "[fd00::1]:80"})
        EXPECT_TRUE(allows_host(allowed, authority)) << authority;
    for (const char* authority : {"a.dots.example", "example", "localhost", "127.0.0.1", "10.0.0.2"})
        EXPECT_FALSE(allows_host(allowed, authority)) << authority;
}

TEST(AllowsHost, AcceptsEverythingIfAnyIsListed) {
    for (const char* authority : {"", "evil.example", "localhost:x"})
        EXPECT_TRUE(allows_host({"dots.example", "*"}, authority)) << authority;
}

TEST(TargetHosts, PermitsListedHosts) {
    const auto hosts = TargetHosts::parse("hooks.Example,[::1],10.0.0.0/8").value();
    for (const auto* host : {"hooks.example", "::1"}) EXPECT_TRUE(hosts.permits(Origin{"http", host, "1"})) << host;
    for (const auto* host : {"", "example", "a.hooks.example", "10.0.0.1", "10.0.0.0/8"})
        EXPECT_FALSE(hosts.permits(Origin{"http", host, "1"})) << host;
    for (const auto* text : {"", "*", "*.a", "a,", "a:80", "10.0.0.0/8", "10.0.0.0/33", "[a]"})
        EXPECT_FALSE(TargetHosts::parse(text)) << text;
}

TEST(TargetHosts, PermitsListedOrigins) {
    const auto hosts = TargetHosts::parse("https://A.example,http://b.example:8080,http://[::1]:81").value();
    EXPECT_TRUE(hosts.permits(Origin{"https", "a.example", "443"}));
    EXPECT_TRUE(hosts.permits(Origin{"http", "b.example", "8080"}));
    EXPECT_TRUE(hosts.permits(Origin{"http", "::1", "81"}));
    EXPECT_TRUE(hosts.permits(IpAddress::parse("::1").value()));
    EXPECT_FALSE(hosts.permits(Origin{"http", "a.example", "443"}));
    EXPECT_FALSE(hosts.permits(Origin{"https", "a.example", "80"}));
    EXPECT_FALSE(hosts.permits(Origin{"http", "b.example", "80"}));
    for (const auto* text : {"https://", "https://a/", "https://a:", "https://a:x", "ftp://a", "//a"})
        EXPECT_FALSE(TargetHosts::parse(text)) << text;
}

TEST(TargetHosts, PermitsPrivateAddressesOnlyIfListed) {
    const auto hosts = TargetHosts::parse("hooks.example,[::1],10.0.0.0/8").value();
    const auto permits = [&](std::string_view text) { return hosts.permits(IpAddress::parse(text).value()); };
    for (const auto* address : {"1.1.1.1", "::1", "10.2.3.4"}) EXPECT_TRUE(permits(address)) << address;
    for (const auto* address : {"127.0.0.1", "192.168.0.1", "169.254.169.254", "fd00::1"})
        EXPECT_FALSE(permits(address)) << address;
}

}  // namespace
}  // namespace ccdt::server

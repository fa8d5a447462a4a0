// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/ip_address.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

std::string read(std::string_view text) {
    const auto address = IpAddress::parse(text);
    return address ? address->text() : "none";
}

bool is_in(std::string_view network, std::string_view address) {
    return IpNetwork::parse(network).value().contains(IpAddress::parse(address).value());
}

TEST(IpAddress, ReadsBothVersions) {
    EXPECT_EQ(read("192.0.2.1"), "192.0.2.1");
    EXPECT_EQ(read("2001:DB8:0::1"), "2001:db8::1");
    EXPECT_EQ(read("::ffff:192.0.2.1"), "192.0.2.1");
    EXPECT_TRUE(IpAddress::parse("::ffff:192.0.2.1")->is_version_4());
    EXPECT_FALSE(IpAddress::parse("::1")->is_version_4());
}

TEST(IpAddress, RefusesInvalidAddresses) {
    using namespace std::string_view_literals;
    for (const auto text : {""sv, "192.0.2"sv, "192.0.2.256"sv, "192.0.2.01"sv, "192.0.2.1 "sv, "192.0.2.1:80"sv,
                            "[::1]"sv, "fe80::1%eth0"sv, "localhost"sv, "192.0.2.1\0"sv, "::1::"sv, "0x7f.1"sv})
        EXPECT_EQ(read(text), "none") << text;
}

TEST(IpAddress, IdentifiesAClientByAddressOrNetwork) {
    EXPECT_EQ(IpAddress::parse("192.0.2.1")->of_one_client(), "192.0.2.1");
    EXPECT_EQ(IpAddress::parse("2001:db8:1:2:3:4:5:6")->of_one_client(), "2001:db8:1:2::");
}

TEST(IpAddress, KnowsPublicAddresses) {
    const auto is_public = [](std::string_view text) { return IpAddress::parse(text).value().is_public(); };
    for (const auto* text : {"1.1.1.1", "9.255.255.255", "100.128.0.1", "172.32.0.1", "223.255.255.255", "2606:4700::1",
                             "2a00:1450:4001::1", "::ffff:8.8.8.8"})
        EXPECT_TRUE(is_public(text)) << text;
    for (const auto* text : {"0.0.0.0",    "10.1.2.3",         "100.64.0.1",  "127.0.0.1",       "169.254.169.254",
                             "172.31.0.1", "192.168.1.1",      "224.0.0.1",   "255.255.255.255", "::",
                             "::1",        "::ffff:127.0.0.1", "::7f00:1",    "64:ff9b::7f00:1", "fc00::1",
                             "fe80::1",    "ff02::1",          "2001:db8::1", "2001:0:1::1",     "2002:7f00:1::"})
        EXPECT_FALSE(is_public(text)) << text;
}

TEST(IpNetwork, ContainsAddressesWithItsPrefix) {
    EXPECT_TRUE(is_in("10.0.0.0/8", "10.255.0.1"));
    EXPECT_FALSE(is_in("10.0.0.0/8", "11.0.0.1"));
    EXPECT_TRUE(is_in("172.16.0.0/12", "172.31.255.255"));
    EXPECT_FALSE(is_in("172.16.0.0/12", "172.32.0.0"));
    EXPECT_TRUE(is_in("192.0.2.7/25", "192.0.2.127"));
    EXPECT_FALSE(is_in("192.0.2.7/25", "192.0.2.128"));
    EXPECT_TRUE(is_in("192.0.2.1", "192.0.2.1"));
    EXPECT_FALSE(is_in("192.0.2.1", "192.0.2.0"));
    EXPECT_TRUE(is_in("0.0.0.0/0", "192.0.2.1"));
    EXPECT_FALSE(is_in("0.0.0.0/0", "2001:db8::1"));
    EXPECT_TRUE(is_in("fd00::/8", "fdff::1"));
    EXPECT_FALSE(is_in("fd00::/8", "fe00::1"));
    EXPECT_TRUE(is_in("10.0.0.0/8", "::ffff:10.1.1.1"));
    EXPECT_TRUE(is_in("::ffff:10.0.0.0/104", "10.1.1.1"));
}

TEST(IpNetwork, RoundTrips) {
    for (const std::string text : {"10.0.0.0/8", "fd00::/8", "::1/128", "192.0.2.1/32", "::/0"})
        EXPECT_EQ(IpNetwork::parse(text)->text(), text);
    EXPECT_EQ(IpNetwork::parse("192.0.2.1")->text(), "192.0.2.1/32");
}

TEST(IpNetwork, RefusesInvalidNetworks) {
    for (const char* text : {"", "/8", "10.0.0.0/", "10.0.0.0/33", "fd00::/129", "10.0.0.0/-1", "10.0.0.0/8x", "10/8",
                             "10.0.0.0/255.0.0.0", " 10.0.0.0/8"})
        EXPECT_FALSE(IpNetwork::parse(text)) << text;
}

}  // namespace
}  // namespace ccdt::server

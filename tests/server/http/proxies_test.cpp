// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/proxies.h"

#include <gtest/gtest.h>

#include "server/http/http.h"

namespace ccdt::server {
namespace {

Peer peer(std::string_view address) {
    return describe_peer(IpAddress::parse(address).value());
}

/// Returns the name of the client of a request with given headers. Trusts the peers 10.0.0.0/8 and fd00::/8.
std::string client(const std::string& headers, const Peer& from = peer("10.0.0.1")) {
    const TrustedProxies proxies{{*IpNetwork::parse("10.0.0.0/8"), *IpNetwork::parse("fd00::/8")}};
    return client_of(parse_head("GET / HTTP/1.1\r\n" + headers + "\r\n").value(), from, proxies).name;
}

std::string listed(const std::string& addresses) {
    return client("X-Forwarded-For: " + addresses + "\r\n");
}

std::string forwarded(const std::string& elements) {
    return client("Forwarded: " + elements + "\r\n");
}

TEST(ClientOf, IsThePeerWithoutHeaders) {
    EXPECT_EQ(client(""), "10.0.0.1");
    EXPECT_EQ(client("", peer("192.0.2.1")), "192.0.2.1");
}

TEST(ClientOf, IgnoresHeadersOfUntrustedPeers) {
    const std::string both = "X-Forwarded-For: 203.0.113.1\r\nForwarded: for=203.0.113.1\r\n";
    for (const char* stranger : {"192.0.2.1", "11.0.0.1", "127.0.0.1", "2001:db8::1"})
        EXPECT_EQ(client(both, peer(stranger)), stranger);
    EXPECT_EQ(client(both, {.name = "unix", .is_local = true}), "unix");
    EXPECT_EQ(client(both, {}), "-");
}

TEST(ClientOf, AcceptsHeadersOfTrustedUnixSockets) {
    const TrustedProxies proxies{.networks = {}, .unix_socket = true};
    const auto request = parse_head("GET / HTTP/1.1\r\nX-Forwarded-For: 203.0.113.1\r\n\r\n").value();
    EXPECT_EQ(client_of(request, {.name = "unix", .is_local = true}, proxies).name, "203.0.113.1");
    EXPECT_EQ(client_of(request, {}, proxies).name, "-");
}

TEST(ClientOf, UsesTheLastAddressThatIsNotATrustedProxy) {
    EXPECT_EQ(listed("203.0.113.1"), "203.0.113.1");
    EXPECT_EQ(listed("198.51.100.1, 203.0.113.1"), "203.0.113.1");
    EXPECT_EQ(listed("198.51.100.1,\t203.0.113.1 , 10.9.9.9,10.0.0.2"), "203.0.113.1");
    EXPECT_EQ(listed("10.0.0.5, 203.0.113.1, 10.0.0.2"), "203.0.113.1");
    EXPECT_EQ(listed("10.0.0.3, 10.0.0.2"), "10.0.0.3") << "one of the proxies' own network asks";
    EXPECT_EQ(listed("2001:db8::1, fd00::2"), "2001:db8::1");
}

TEST(ClientOf, JoinsRepeatedHeaderFields) {
    EXPECT_EQ(client("X-Forwarded-For: 198.51.100.1\r\nx-forwarded-for: 203.0.113.1\r\n"), "203.0.113.1");
    EXPECT_EQ(client("X-Forwarded-For: 203.0.113.1\r\nX-Forwarded-For: 10.0.0.2\r\n"), "203.0.113.1");
    EXPECT_EQ(client("Forwarded: for=198.51.100.1\r\nForwarded: for=203.0.113.1\r\n"), "203.0.113.1");
}

TEST(ClientOf, IgnoresPorts) {
    EXPECT_EQ(listed("203.0.113.1:4711"), "203.0.113.1");
    EXPECT_EQ(listed("[2001:db8::1]:4711"), "2001:db8::1");
    EXPECT_EQ(listed("[2001:db8::1]"), "2001:db8::1");
    EXPECT_EQ(listed("::ffff:203.0.113.1"), "203.0.113.1");
}

TEST(ClientOf, StopsAtInvalidAddresses) {
    for (const char* none : {"unknown", "_hidden", "203.0.113", "203.0.113.1:", "203.0.113.1:x", "203.0.113.1:123456",
                             "[2001:db8::1", "[203.0.113.1]", "[2001:db8::1]80", "2001:db8::1]", "\"203.0.113.1\"",
                             "203.0.113.1 203.0.113.2", "localhost", "fe80::1%eth0"}) {
        EXPECT_EQ(listed(std::string("203.0.113.9, ") + none), "10.0.0.1") << none;
        EXPECT_EQ(listed(std::string("203.0.113.9, ") + none + ", 10.0.0.2"), "10.0.0.2") << none;
        EXPECT_EQ(listed(std::string(none) + ", 203.0.113.1"), "203.0.113.1") << none;
    }
    EXPECT_EQ(listed(" , ,, "), "10.0.0.1");
    EXPECT_EQ(listed("203.0.113.1,, ,"), "203.0.113.1") << "a list may have empty places";
}

TEST(ClientOf, ReadsTheForwardedHeader) {
    EXPECT_EQ(forwarded("for=203.0.113.1"), "203.0.113.1");
    EXPECT_EQ(forwarded("For=\"[2001:DB8:cafe::17]:4711\""), "2001:db8:cafe::17");
    EXPECT_EQ(forwarded("for=203.0.113.1;proto=http;by=203.0.113.43"), "203.0.113.1");
    EXPECT_EQ(forwarded("proto=https ; FOR = \"203.0.113.1:80\"; host=\"a,b;c\\\"d\""), "203.0.113.1");
    EXPECT_EQ(forwarded("for=198.51.100.1, for=203.0.113.1;by=10.0.0.9, for=10.0.0.2"), "203.0.113.1");
    EXPECT_EQ(forwarded("for=203.0.113.1, for=unknown"), "10.0.0.1");
    EXPECT_EQ(forwarded("for=203.0.113.1, for=_secret, for=10.0.0.2"), "10.0.0.2");
    EXPECT_EQ(forwarded("for=203.0.113.1, proto=http"), "10.0.0.1") << "its proxy does not tell";
}

TEST(ClientOf, IgnoresMalformedForwardedHeaders) {
    for (const char* broken : {"for=203.0.113.1;for=203.0.113.2", "for=\"203.0.113.1", "for=\"a\\", "for", "for=", "=",
                               "203.0.113.1", "for=203.0.113.1\"", "for=\"\\203.0.113.1\"", "fo\"r=203.0.113.1\""})
        EXPECT_EQ(forwarded(broken), "10.0.0.1") << broken;
    // Text from the client precedes the address from the proxy, in the same field or in a separate one.
    for (const char* evil : {"for=\"", "by=\"\\", "for=1.2.3.4;by=\"x", "for=1.2.3.4,\"", "\"", "\\\""}) {
        const auto told = forwarded(std::string(evil) + ", for=203.0.113.1");
        EXPECT_TRUE(told == "10.0.0.1" || told == "203.0.113.1") << evil << " -> " << told;
        EXPECT_EQ(client("Forwarded: " + std::string(evil) + "\r\nForwarded: for=203.0.113.1\r\n"), "203.0.113.1");
        const auto quoted = forwarded(std::string(evil) + ", for=\"[2001:db8::1]\"");
        EXPECT_TRUE(quoted == "10.0.0.1" || quoted == "2001:db8::1") << evil << " -> " << quoted;
    }
}

TEST(ClientOf, UsesTwoHeadersOnlyIfTheyAgree) {
    EXPECT_EQ(client("Forwarded: for=203.0.113.1\r\nX-Forwarded-For: 203.0.113.1\r\n"), "203.0.113.1");
    EXPECT_EQ(client("Forwarded: for=203.0.113.1\r\nX-Forwarded-For: 203.0.113.2\r\n"), "10.0.0.1");
    EXPECT_EQ(client("X-Forwarded-For: 203.0.113.2\r\nForwarded: for=unknown\r\n"), "10.0.0.1");
    EXPECT_EQ(client("X-Forwarded-For: 203.0.113.2\r\nForwarded: \r\n"), "10.0.0.1");
}

}  // namespace
}  // namespace ccdt::server

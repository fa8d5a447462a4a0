// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/proxy_protocol.h"

#include <gtest/gtest.h>

#include <string>

namespace ccdt::server {
namespace {

using namespace std::string_literals;
using State = ProxyHeader::State;

/// Returns `none`, `partial`, `malformed`, or the name of the client and the size of the header in bytes.
std::string read(std::string_view bytes) {
    const auto header = parse_proxy_header(bytes);
    if (!header) return header.error().status == 400 ? "malformed" : "?";
    if (header->state == State::None) return "none";
    if (header->state == State::Partial) return "partial";
    return (header->client ? header->client->name : "proxy") + " in " + std::to_string(header->size);
}

/// Returns a header of version 2; `family` includes the transport.
std::string version_2(char command, char family, const std::string& rest) {
    const auto size = rest.size();
    return "\r\n\r\n\0\r\nQUIT\n"s + command + family + static_cast<char>(size >> 8) + static_cast<char>(size) + rest;
}

const std::string kVersion4 = "\xcb\x00\x71\x01\x0a\x00\x00\x01\x12\x67\x00\x50"s;
const std::string kVersion6 =
    "\x20\x01\x0d\xb8"s + std::string(11, '\0') + "\x01" + std::string(16, '\0') + "\x12\x67\x00\x50"s;

TEST(ProxyHeader, ReadsVersion1) {
    EXPECT_EQ(read("PROXY TCP4 203.0.113.1 10.0.0.1 4711 80\r\nGET /"), "203.0.113.1:4711 in 41");
    EXPECT_EQ(read("PROXY TCP6 2001:db8::1 fd00::1 4711 80\r\n"), "[2001:db8::1]:4711 in 40");
    EXPECT_EQ(read("PROXY UNKNOWN\r\nGET /"), "proxy in 15");
    EXPECT_EQ(read("PROXY UNKNOWN 203.0.113.1 10.0.0.1 4711 80\r\n"), "proxy in 44");
}

TEST(ProxyHeader, RefusesMalformedVersion1) {
    for (const char* line : {"TCP4 203.0.113.1 10.0.0.1 4711", "TCP4 203.0.113.1 10.0.0.1 4711 80 ", "TCP4", "",
                             "TCP4 203.0.113.1  10.0.0.1 4711 80", "TCP4 2001:db8::1 fd00::1 4711 80",
                             "TCP4 203.0.113.1 10.0.0.1 4711 65536", "TCP4 203.0.113.1 10.0.0.1 -1 80",
                             "TCP4 203.0.113.256 10.0.0.1 4711 80", "UDP4 203.0.113.1 10.0.0.1 4711 80",
                             "tcp4 203.0.113.1 10.0.0.1 4711 80", "UNKNOWNS"})
        EXPECT_EQ(read("PROXY "s + line + "\r\n"), "malformed") << line;
    EXPECT_EQ(read("PROXY UNKNOWN " + std::string(200, 'x') + "\r\n"), "malformed");
    EXPECT_EQ(read("PROXY UNKNOWN " + std::string(93, 'x')), "malformed");
    EXPECT_EQ(read("PROXY UNKNOWN " + std::string(91, 'x') + "\r\n"), "proxy in 107");
}

TEST(ProxyHeader, ReadsVersion2) {
    EXPECT_EQ(read(version_2('\x21', '\x11', kVersion4) + "GET /"), "203.0.113.1:4711 in 28");
    EXPECT_EQ(read(version_2('\x21', '\x21', kVersion6) + "GET /"), "[2001:db8::1]:4711 in 52");
    EXPECT_EQ(read(version_2('\x21', '\x11', kVersion4 + std::string(500, 'x'))), "203.0.113.1:4711 in 528");
    EXPECT_EQ(read(version_2('\x20', '\x11', kVersion4)), "proxy in 28")
        << "health checks of the proxy use this command";
    EXPECT_EQ(read(version_2('\x20', '\x00', "")), "proxy in 16");
    EXPECT_EQ(read(version_2('\x21', '\x00', "")), "proxy in 16");
    EXPECT_EQ(read(version_2('\x21', '\x31', std::string(216, 'x'))), "proxy in 232") << "the family of Unix sockets";
}

TEST(ProxyHeader, RefusesMalformedVersion2) {
    EXPECT_EQ(read(version_2('\x22', '\x11', kVersion4)), "malformed");
    EXPECT_EQ(read(version_2('\x11', '\x11', kVersion4)), "malformed");
    EXPECT_EQ(read(version_2('\x21', '\x11', kVersion4.substr(1))), "malformed");
    EXPECT_EQ(read(version_2('\x21', '\x21', kVersion4)), "malformed");
}

TEST(ProxyHeader, WaitsForTheRest) {
    for (const auto& whole : {"PROXY TCP4 203.0.113.1 10.0.0.1 4711 80\r\n"s, version_2('\x21', '\x21', kVersion6)})
        for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_EQ(read(whole.substr(0, size)), "partial");
}

TEST(ProxyHeader, IgnoresOtherBeginnings) {
    for (const char* other : {"GET / HTTP/1.1\r\n", "PUT", "PROXX", "PROXY/", "\r\nGET", "\r\n\r\nGET", "proxy TCP4"})
        EXPECT_EQ(read(other), "none") << other;
}

}  // namespace
}  // namespace ccdt::server

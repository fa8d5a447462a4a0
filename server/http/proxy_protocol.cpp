// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/proxy_protocol.h"

#include <netinet/in.h>

#include <cstdint>
#include <cstring>
#include <utility>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

using State = ProxyHeader::State;

constexpr std::string_view kVersion1 = "PROXY ";
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::size_t kLongestLine = 107;  ///< including its CRLF

constexpr std::string_view kVersion2{"\r\n\r\n\0\r\nQUIT\n", 12};
constexpr std::size_t kFixedSize = 16;  ///< signature, version and command, family and transport, remaining length
constexpr std::uint8_t kLocal = 0x20;   ///< version and command
constexpr std::uint8_t kProxied = 0x21;
constexpr std::uint8_t kTcpVersion4 = 0x11;  ///< family and transport
constexpr std::uint8_t kTcpVersion6 = 0x21;

std::uint8_t byte(std::string_view bytes, std::size_t at) {
    return static_cast<std::uint8_t>(bytes[at]);
}

std::uint16_t number(std::string_view bytes, std::size_t at) {
    return static_cast<std::uint16_t>(byte(bytes, at) << 8 | byte(bytes, at + 1));
}

tl::unexpected<Problem> malformed() {
    return problem(400, "the PROXY header is malformed");
}

/// Parses the words after `PROXY TCP4` or `PROXY TCP6` (both addresses, both ports), and returns the client.
HttpResult<Peer> parse_addresses(std::string_view words, bool version_4) {
    const auto client = IpAddress::parse(api::take_until(words, " "));
    const auto proxy = IpAddress::parse(api::take_until(words, " "));
    const auto client_port = api::parse_number<std::uint16_t>(api::take_until(words, " "));
    const auto proxy_port = api::parse_number<std::uint16_t>(words);
    if (!client || !proxy || !client_port || !proxy_port) return malformed();
    if (version_4 && !client->is_version_4()) return malformed();
    return describe_peer(*client, *client_port);
}

HttpResult<ProxyHeader> parse_version_1(std::string_view received) {
    const auto end = received.substr(0, kLongestLine).find(kLineEnd);
    if (end == std::string_view::npos && received.size() >= kLongestLine) return malformed();
    if (end == std::string_view::npos) return ProxyHeader{State::Partial, 0, {}};
    ProxyHeader header{State::Whole, end + kLineEnd.size(), {}};
    auto words = received.substr(kVersion1.size(), end - kVersion1.size());
    const auto family = api::take_until(words, " ");
    if (family == "UNKNOWN") return header;
    if (family != "TCP4" && family != "TCP6") return malformed();
    return parse_addresses(words, family == "TCP4").map([&](Peer client) {
        header.client = std::move(client);
        return header;
    });
}

/// Reads the client from the addresses of version 2: client and proxy address, client and proxy port, in binary.
template <class Address>
HttpResult<Peer> parse_addresses(std::string_view bytes) {
    if (bytes.size() < 2 * sizeof(Address) + 4) return malformed();
    Address client;
    std::memcpy(&client, bytes.data(), sizeof(client));
    return describe_peer(IpAddress(client), number(bytes, 2 * sizeof(Address)));
}

HttpResult<ProxyHeader> parse_version_2(std::string_view received) {
    if (received.size() < kFixedSize) return ProxyHeader{State::Partial, 0, {}};
    const auto command = byte(received, kVersion2.size());
    const auto family = byte(received, kVersion2.size() + 1);
    if (command != kLocal && command != kProxied) return malformed();
    ProxyHeader header{State::Whole, kFixedSize + number(received, kVersion2.size() + 2), {}};
    if (received.size() < header.size) return ProxyHeader{State::Partial, 0, {}};
    if (command == kLocal || (family != kTcpVersion4 && family != kTcpVersion6)) return header;
    const auto rest = received.substr(kFixedSize, header.size - kFixedSize);
    const auto client = family == kTcpVersion4 ? parse_addresses<in_addr>(rest) : parse_addresses<in6_addr>(rest);
    return client.map([&](const Peer& peer) {
        header.client = peer;
        return header;
    });
}

}  // namespace

HttpResult<ProxyHeader> parse_proxy_header(std::string_view received) {
    if (received.starts_with(kVersion1)) return parse_version_1(received);
    if (received.starts_with(kVersion2)) return parse_version_2(received);
    const bool may_begin_one = kVersion1.starts_with(received) || kVersion2.starts_with(received);
    return ProxyHeader{may_begin_one ? State::Partial : State::None, 0, {}};
}

}  // namespace ccdt::server

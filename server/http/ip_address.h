// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <netinet/in.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ccdt::server {

/// An IP address of version 4 or 6. An IPv4-mapped IPv6 address (RFC 4291, 2.5.5.2) equals the IPv4 address.
class IpAddress {
public:
    explicit IpAddress(const in_addr& address);
    explicit IpAddress(const in6_addr& address);

    /// Parses an address such as `192.0.2.1` or `2001:db8::1`; none if malformed or with a bracket, port or zone.
    static std::optional<IpAddress> parse(std::string_view text);

    bool is_version_4() const;

    /// Whether the address is of the public Internet: not private, local, multicast or otherwise reserved (IANA's
    /// registries of special-purpose addresses).
    bool is_public() const;

    std::string text() const;

    /// Returns the text by which limits identify a client: the IPv4 address, or the IPv6 /64 network.
    std::string of_one_client() const;

    /// Whether the first `bits` of 128 bits are equal in both addresses. IPv4 addresses are compared in IPv4-mapped
    /// form, as the last 32 bits.
    bool shares(const IpAddress& other, int bits) const;

private:
    std::array<std::uint8_t, 16> bytes_{};  ///< in IPv6 form; IPv4 addresses are IPv4-mapped
};

/// A network: all addresses with a common prefix.
class IpNetwork {
public:
    /// Parses a network such as `10.0.0.0/8` or `fd00::/8`, or a single address. Bits after the prefix are ignored.
    /// @returns  none if the text is malformed
    static std::optional<IpNetwork> parse(std::string_view text);

    bool contains(const IpAddress& address) const { return address.shares(base_, bits_); }

    std::string text() const;

private:
    IpNetwork(const IpAddress& base, int bits) : base_(base), bits_(bits) {}

    IpAddress base_;
    int bits_;  ///< number of leading bits, out of 128, that all addresses share
};

}  // namespace ccdt::server

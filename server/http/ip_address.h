// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <netinet/in.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ccdt::server {

/// An IP address of version 4 or 6. An IPv4-mapped IPv6 address, such as `::ffff:192.0.2.1`, equals the IPv4 address.
class IpAddress {
public:
    explicit IpAddress(const in_addr& address);
    explicit IpAddress(const in6_addr& address);

    /// Parses `192.0.2.1` or `2001:db8::1`, without brackets, port or zone; none if it is neither.
    static std::optional<IpAddress> parse(std::string_view text);

    bool is_version_4() const;
    std::string text() const;

    /// Returns, as text, the range of addresses that counts as one client: an IPv4 address, or a 64-bit IPv6 network.
    std::string of_one_client() const;

    /// Whether the first `bits` of the 128 bits of both addresses are equal. An IPv4 address is the last 32 of its 128
    /// bits.
    bool shares(const IpAddress& other, int bits) const;

private:
    std::array<std::uint8_t, 16> bytes_{};  ///< in IPv6 form, IPv4 addresses as IPv4-mapped ones
};

/// Addresses with a common prefix.
class IpNetwork {
public:
    /// Parses `10.0.0.0/8`, `fd00::/8`, or an address, which is a network of one. Bits after the prefix are ignored.
    /// @returns  none if the text is malformed
    static std::optional<IpNetwork> parse(std::string_view text);

    bool contains(const IpAddress& address) const { return address.shares(base_, bits_); }

    std::string text() const;

private:
    IpNetwork(const IpAddress& base, int bits) : base_(base), bits_(bits) {}

    IpAddress base_;
    int bits_;  ///< length of the prefix of the 128 bits
};

}  // namespace ccdt::server

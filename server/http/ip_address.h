#pragma once

#include <netinet/in.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ccdt::server {

/// An address of the internet protocol, of version 4 or 6. One of version 4 that is written in version 6, as
/// `::ffff:192.0.2.1`, is the same as without that.
class IpAddress {
public:
    explicit IpAddress(const in_addr& address);
    explicit IpAddress(const in6_addr& address);

    /// Reads `192.0.2.1` or `2001:db8::1`, without brackets, port or zone; none if it is neither.
    static std::optional<IpAddress> parse(std::string_view text);

    bool is_version_4() const;
    std::string text() const;

    /// What one client has for itself, as text: an address of version 4, a network of 64 bits of version 6.
    std::string of_one_client() const;

    /// Whether the first bits are the same, of 128; version 4 has 96 before its own.
    bool shares(const IpAddress& other, int bits) const;

private:
    std::array<std::uint8_t, 16> bytes_{};  ///< as in version 6
};

/// Addresses that begin alike.
class IpNetwork {
public:
    /// Reads `10.0.0.0/8`, `fd00::/8` or an address, which is a network of one. Bits beyond the first do not count.
    /// None if it is none of these.
    static std::optional<IpNetwork> parse(std::string_view text);

    bool contains(const IpAddress& address) const { return address.shares(base_, bits_); }

    std::string text() const;

private:
    IpNetwork(const IpAddress& base, int bits) : base_(base), bits_(bits) {}

    IpAddress base_;
    int bits_;  ///< of 128
};

}  // namespace ccdt::server

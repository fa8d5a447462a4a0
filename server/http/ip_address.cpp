// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/ip_address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

constexpr int kBits = 128;
constexpr int kBitsBeforeVersion4 = 96;
constexpr std::array<std::uint8_t, 12> kBeforeVersion4{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
constexpr std::size_t kBytesOfOneClient = 8;

}  // namespace

IpAddress::IpAddress(const in_addr& address) {
    const auto rest = std::ranges::copy(kBeforeVersion4, bytes_.begin()).out;
    std::memcpy(&*rest, &address, sizeof(address));
}

IpAddress::IpAddress(const in6_addr& address) {
    std::memcpy(bytes_.data(), &address, sizeof(address));
}

std::optional<IpAddress> IpAddress::parse(std::string_view text) {
    const std::string copy(text);
    if (copy.find('\0') != std::string::npos) return std::nullopt;
    in_addr version_4{};
    if (inet_pton(AF_INET, copy.c_str(), &version_4) == 1) return IpAddress(version_4);
    in6_addr version_6{};
    if (inet_pton(AF_INET6, copy.c_str(), &version_6) == 1) return IpAddress(version_6);
    return std::nullopt;
}

bool IpAddress::is_version_4() const {
    return std::equal(kBeforeVersion4.begin(), kBeforeVersion4.end(), bytes_.begin());
}

bool IpAddress::is_public() const {
    static const auto networks = [](std::initializer_list<std::string_view> texts) {
        std::vector<IpNetwork> all;
        for (const auto text : texts) all.push_back(*IpNetwork::parse(text));
        return all;
    };
    static const auto reserved =
        networks({"0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16", "172.16.0.0/12",
                  "192.0.0.0/24", "192.0.2.0/24", "192.88.99.0/24", "192.168.0.0/16", "198.18.0.0/15",
                  "198.51.100.0/24", "203.0.113.0/24", "224.0.0.0/3", "2001::/23", "2001:db8::/32", "2002::/16"});
    static const auto global = networks({"::ffff:0:0/96", "2000::/3"});
    const auto contains = [this](const IpNetwork& network) { return network.contains(*this); };
    return std::ranges::any_of(global, contains) && std::ranges::none_of(reserved, contains);
}

std::string IpAddress::text() const {
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (is_version_4()) return inet_ntop(AF_INET, &bytes_[kBeforeVersion4.size()], text.data(), text.size());
    return inet_ntop(AF_INET6, bytes_.data(), text.data(), text.size());
}

std::string IpAddress::of_one_client() const {
    if (is_version_4()) return text();
    IpAddress network = *this;
    std::fill(network.bytes_.begin() + kBytesOfOneClient, network.bytes_.end(), std::uint8_t{0});
    return network.text();
}

bool IpAddress::shares(const IpAddress& other, int bits) const {
    const auto whole = static_cast<std::size_t>(bits / 8);
    if (!std::equal(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(whole), other.bytes_.begin()))
        return false;
    const int remaining = bits % 8;
    return remaining == 0 || (bytes_[whole] ^ other.bytes_[whole]) >> (8 - remaining) == 0;
}

std::optional<IpNetwork> IpNetwork::parse(std::string_view text) {
    const auto slash = text.find('/');
    const auto base = IpAddress::parse(text.substr(0, slash));
    if (!base) return std::nullopt;
    if (slash == std::string_view::npos) return IpNetwork(*base, kBits);
    const int before = text.find(':') == std::string_view::npos ? kBitsBeforeVersion4 : 0;
    const auto bits = api::parse_number<std::uint64_t>(text.substr(slash + 1));
    if (!bits || *bits > static_cast<std::uint64_t>(kBits - before)) return std::nullopt;
    return IpNetwork(*base, before + static_cast<int>(*bits));
}

std::string IpNetwork::text() const {
    const bool shorter = base_.is_version_4() && bits_ >= kBitsBeforeVersion4;
    return base_.text() + '/' + std::to_string(shorter ? bits_ - kBitsBeforeVersion4 : bits_);
}

}  // namespace ccdt::server

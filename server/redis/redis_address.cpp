// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_address.h"

#include <cstdint>
#include <optional>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kExpected = "redis://[[user]:password@]host[:port][/database], or rediss:// for TLS";

/// Decodes percent-encoding.
/// @returns  none if a % is not followed by two hexadecimal digits
std::optional<std::string> decode(std::string_view text) {
    std::string decoded;
    while (!text.empty()) {
        if (text.front() != '%') {
            decoded += text.front();
            text.remove_prefix(1);
            continue;
        }
        const auto code = api::parse_number<std::uint8_t>(text.substr(1, 2), 16);
        if (text.size() < 3 || !code) return std::nullopt;
        decoded += static_cast<char>(*code);
        text.remove_prefix(3);
    }
    return decoded;
}

bool set_credentials(RedisAddress& address, std::string_view text) {
    const auto user = decode(api::take_until(text, ":"));
    const auto password = decode(text);
    if (!user || !password || password->empty()) return false;
    address.user = *user;
    address.password = *password;
    return true;
}

/// Parses `host:port` or `[address]:port` into an address. Returns false if the text is malformed.
bool set_place(RedisAddress& address, std::string_view text) {
    std::string_view host;
    if (text.starts_with('[')) {
        text.remove_prefix(1);
        host = api::take_until(text, "]");
        if (!text.empty() && !text.starts_with(':')) return false;
        if (!text.empty()) text.remove_prefix(1);
    } else {
        host = api::take_until(text, ":");
    }
    if (!host.empty()) address.host = host;
    if (text.empty()) return true;
    if (!api::parse_number<std::uint16_t>(text)) return false;
    address.port = text;
    return true;
}

bool set_database(RedisAddress& address, std::string_view text) {
    if (text.empty()) return true;
    const auto number = api::parse_number<std::uint16_t>(text);
    address.database = number.value_or(0);
    return number.has_value();
}

}  // namespace

Result<RedisAddress> RedisAddress::parse(std::string_view text) {
    const auto scheme = api::take_until(text, "://");
    if (scheme.find("sentinel") != std::string_view::npos)
        return failure(ErrorCode::Malformed,
                       "Sentinel is not supported; name the Redis itself, or a proxy in front of it");
    RedisAddress address;
    address.encrypted = scheme == "rediss";
    bool right = scheme == "redis" || address.encrypted;
    if (const auto at = text.rfind('@'); at != std::string_view::npos) {
        right = right && set_credentials(address, text.substr(0, at));
        text.remove_prefix(at + 1);
    }
    const auto position = api::take_until(text, "/");
    if (position.find(',') != std::string_view::npos)
        return failure(ErrorCode::Malformed, "several addresses are not supported; name one Redis");
    right = right && set_place(address, position) && set_database(address, text);
    if (!right) return failure(ErrorCode::Malformed, "the address must have the form " + std::string(kExpected));
    return address;
}

}  // namespace ccdt::server

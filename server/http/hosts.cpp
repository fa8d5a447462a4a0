// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/hosts.h"

#include <algorithm>
#include <cstdint>

#include <arpa/inet.h>

#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {

bool is_loopback(std::string_view host) {
    if (host == "localhost" || host.ends_with(".localhost") || host == "::1") return true;
    in_addr address{};
    if (inet_pton(AF_INET, std::string(host).c_str(), &address) != 1) return false;
    return ntohl(address.s_addr) >> 24 == IN_LOOPBACKNET;
}

std::optional<std::string_view> host_of_authority(std::string_view authority) {
    std::string_view host = authority;
    if (const auto colon = host.find_last_of(":]"); colon != std::string_view::npos && host[colon] == ':') {
        if (!api::parse_number<std::uint16_t>(host.substr(colon + 1))) return std::nullopt;
        host = host.substr(0, colon);
    }
    if (!host.starts_with('[')) return host;
    if (!host.ends_with(']')) return std::nullopt;
    return host.substr(1, host.size() - 2);
}

bool allows_host(const std::vector<std::string>& allowed, std::string_view authority) {
    if (authority.empty() || std::ranges::find(allowed, kAny) != allowed.end()) return true;
    auto host = host_of_authority(authority);
    if (!host || host->empty()) return false;
    if (host->ends_with('.')) host->remove_suffix(1);  // a trailing dot denotes the DNS root and is redundant
    const std::string name = to_lower_case(*host);
    return std::ranges::any_of(
        allowed, [&](const std::string& one) { return one == kLoopback ? is_loopback(name) : one == name; });
}

}  // namespace ccdt::server

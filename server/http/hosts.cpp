// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/hosts.h"

#include <algorithm>
#include <cstdint>

#include <arpa/inet.h>

#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

std::string name_of(const Origin& origin) {
    return origin.scheme + "://" + origin.host + ':' + origin.port;
}

/// Parses an origin such as `https://pictures.example:8443`; none if the text is not one.
std::optional<Origin> parse_origin(std::string_view text) {
    const auto end = text.find("://");
    const auto scheme = text.substr(0, end);
    if (end == std::string_view::npos || (scheme != "http" && scheme != "https")) return std::nullopt;
    const auto authority = text.substr(end + 3);
    const auto mark = authority.find_last_of(":]");
    const auto colon = mark != std::string_view::npos && authority[mark] == ':' ? mark : authority.size();
    const auto host = parse_host(authority.substr(0, colon));
    const auto port = colon == authority.size() ? std::optional<std::uint16_t>(scheme == "http" ? 80 : 443)
                                                : api::parse_number<std::uint16_t>(authority.substr(colon + 1));
    if (!host || !port) return std::nullopt;
    return Origin{std::string(scheme), *host, std::to_string(*port)};
}

}  // namespace

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

std::optional<std::string> parse_host(std::string_view text) {
    const bool has_brackets = text.starts_with('[') && text.ends_with(']');
    if (has_brackets) text = text.substr(1, text.size() - 2);
    if (const auto address = IpAddress::parse(text)) return address->text();
    const auto is_of_name = [](char c) { return c > ' ' && c < 0x7f && c != ':' && c != '/' && c != '*'; };
    if (text == kAny) return std::string(kAny);
    if (text.empty() || has_brackets || !std::ranges::all_of(text, is_of_name)) return std::nullopt;
    return to_lower_case(text);
}

std::optional<TargetHosts> TargetHosts::parse(std::string_view text) {
    TargetHosts hosts;
    for (bool more = true; more;) {
        more = text.find(',') != std::string_view::npos;
        const auto one = api::take_until(text, ",");
        const auto origin = parse_origin(one);
        const auto host = origin ? origin->host : parse_host(one);
        const auto network = IpNetwork::parse(host ? *host : one);
        if ((!network && !host) || host == kAny) return std::nullopt;
        if (network) hosts.networks.push_back(*network);
        if (host) hosts.names.push_back(origin ? name_of(*origin) : *host);
    }
    if (hosts.names.empty()) return std::nullopt;
    return hosts;
}

bool TargetHosts::permits(const Origin& origin) const {
    return std::ranges::any_of(names,
                               [&](const std::string& name) { return name == origin.host || name == name_of(origin); });
}

bool TargetHosts::permits(const IpAddress& address) const {
    return address.is_public() ||
           std::ranges::any_of(networks, [&](const IpNetwork& network) { return network.contains(address); });
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

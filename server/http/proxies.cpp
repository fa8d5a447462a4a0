// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/proxies.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kLongestPort = 5;

/// Addresses in a header field, in the order in which proxies wrote them; none for a malformed address.
using Hops = std::vector<std::optional<IpAddress>>;

bool is_port(std::string_view text) {
    return !text.empty() && text.size() <= kLongestPort &&
           std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Parses an address with an optional port. An IPv6 address with a port must be in brackets.
std::optional<IpAddress> parse_node(std::string_view text) {
    if (text.starts_with('[')) {
        const auto end = text.find(']');
        const auto address = text.substr(1, end - 1);
        if (end == std::string_view::npos || address.find(':') == std::string_view::npos) return std::nullopt;
        const auto rest = text.substr(end + 1);
        return rest.empty() || (rest.front() == ':' && is_port(rest.substr(1))) ? IpAddress::parse(address)
                                                                                : std::nullopt;
    }
    const auto colon = text.find(':');
    if (colon == std::string_view::npos || text.find(':', colon + 1) != std::string_view::npos)
        return IpAddress::parse(text);
    return is_port(text.substr(colon + 1)) ? IpAddress::parse(text.substr(0, colon)) : std::nullopt;
}

Hops x_forwarded_for(std::string_view field) {
    Hops hops;
    while (!field.empty()) {
        const auto node = api::trim(api::take_until(field, ","));
        if (!node.empty()) hops.push_back(parse_node(node));
    }
    return hops;
}

/// Removes enclosing quotes, if any. Does not decode escapes, because addresses need none.
std::string_view unquote(std::string_view value) {
    const bool quoted = value.size() >= 2 && value.starts_with('"') && value.ends_with('"');
    return quoted ? value.substr(1, value.size() - 2) : value;
}

/// Parses the `for` address of a Forwarded element such as `for="[2001:db8::1]:80";proto=https`; none if malformed.
std::optional<IpAddress> forwarded_for(std::string_view element) {
    std::optional<IpAddress> found;
    for (bool seen = false; !element.empty();) {
        auto value = take_unquoted(element, ';').value_or("");
        const auto name = api::trim(api::take_until(value, "="));
        if (!equals_ignoring_case(name, "for")) continue;
        if (std::exchange(seen, true)) return std::nullopt;
        found = parse_node(unquote(api::trim(value)));
    }
    return found;
}

Hops forwarded(std::string_view field) {
    Hops hops;
    while (!field.empty()) {
        const auto element = take_unquoted(field, ',');
        if (!element) return {std::nullopt};  // the end of the element is unknown
        if (!api::trim(*element).empty()) hops.push_back(forwarded_for(*element));
    }
    return hops;
}

/// Finds the client by following the addresses in all fields of a header, from the last to the first.
/// @returns  none if the request does not contain the header
std::optional<Peer> follow(const Request& request, std::string_view header, Hops (*read)(std::string_view),
                           const Peer& peer, const TrustedProxies& proxies) {
    std::optional<Peer> client;
    for (auto field = request.headers.rbegin(); field != request.headers.rend(); ++field) {
        if (!equals_ignoring_case(field->name, header)) continue;
        if (!client) client = peer;
        const Hops hops = read(field->value);
        for (auto hop = hops.rbegin(); hop != hops.rend(); ++hop) {
            if (!*hop || !proxies.include(*client)) return client;
            client = describe_peer(**hop);
        }
    }
    return client;
}

}  // namespace

bool TrustedProxies::include(const Peer& peer) const {
    if (!peer.ip) return unix_socket && peer.is_local;
    return std::ranges::any_of(networks, [&](const IpNetwork& network) { return network.contains(*peer.ip); });
}

Peer client_of(const Request& request, const Peer& peer, const TrustedProxies& proxies) {
    if (!proxies.include(peer)) return peer;
    const auto one = follow(request, "X-Forwarded-For", x_forwarded_for, peer, proxies);
    const auto other = follow(request, "Forwarded", forwarded, peer, proxies);
    if (one && other && one->name != other->name) return peer;
    return one ? *one : other.value_or(peer);
}

}  // namespace ccdt::server

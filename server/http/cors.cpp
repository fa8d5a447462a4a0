#include "server/http/cors.h"

#include <algorithm>
#include <optional>

#include <arpa/inet.h>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

/// Takes the host out of an origin of the web, `http://host:port`; nothing if it is no such, or has anything else.
std::optional<std::string_view> host_of(std::string_view origin) {
    const auto scheme_end = origin.find("://");
    if (scheme_end == std::string_view::npos) return std::nullopt;
    const auto scheme = origin.substr(0, scheme_end);
    if (scheme != "http" && scheme != "https") return std::nullopt;
    std::string_view host = origin.substr(scheme_end + 3);
    if (const auto colon = host.find_last_of(":]"); colon != std::string_view::npos && host[colon] == ':') {
        if (!api::parse_number<std::uint16_t>(host.substr(colon + 1))) return std::nullopt;
        host = host.substr(0, colon);
    }
    if (!host.starts_with('[')) return host;
    if (!host.ends_with(']')) return std::nullopt;
    return host.substr(1, host.size() - 2);
}

bool is_loopback_origin(std::string_view origin) {
    const auto host = host_of(origin);
    return host && is_loopback(*host);
}

}  // namespace

bool is_loopback(std::string_view host) {
    if (host == "localhost" || host.ends_with(".localhost") || host == "::1") return true;
    in_addr address{};
    if (inet_pton(AF_INET, std::string(host).c_str(), &address) != 1) return false;
    return ntohl(address.s_addr) >> 24 == IN_LOOPBACKNET;
}

bool allows_origin(const std::vector<std::string>& allowed, std::string_view origin) {
    return std::ranges::any_of(allowed, [&](const std::string& one) {
        return one == "*" || one == origin || (one == kLoopbackOrigins && is_loopback_origin(origin));
    });
}

std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin) {
    if (allowed.empty()) return {};
    const Header exposed{"Access-Control-Expose-Headers",
                         "ETag, Location, Preference-Applied, Retry-After, Server-Timing, X-Partial, X-Radius, "
                         "X-Repaired, X-Request-ID, X-Warnings, "
                         "X-Tone"};
    if (std::ranges::find(allowed, "*") != allowed.end()) return {{"Access-Control-Allow-Origin", "*"}, exposed};
    // Caches must not give one origin's answer to another, not even one without permission.
    std::vector<Header> headers{{"Vary", "Origin"}};
    if (!allows_origin(allowed, origin)) return headers;
    headers.push_back({"Access-Control-Allow-Origin", std::string(origin)});
    headers.push_back(exposed);
    return headers;
}

std::vector<Header> preflight_headers(std::string_view methods) {
    return {{"Access-Control-Allow-Methods", std::string(methods)},
            {"Access-Control-Allow-Headers",
             "Accept, Authorization, Content-Type, If-None-Match, Last-Event-ID, Prefer, X-Request-ID"},
            {"Access-Control-Max-Age", "86400"}};
}

bool asks_for_other_origin(const Request& request) {
    if (request.header("Origin").empty()) return false;
    if (request.method == "OPTIONS") return !request.header("Access-Control-Request-Method").empty();
    const auto site = request.header("Sec-Fetch-Site");
    return request.header("Sec-Fetch-Mode") == "cors" && !site.empty() && site != "same-origin";
}

}  // namespace ccdt::server

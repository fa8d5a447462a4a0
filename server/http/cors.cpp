// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/cors.h"

#include <algorithm>
#include <optional>

#include "server/http/hosts.h"

namespace ccdt::server {
namespace {

/// Returns the host of an origin of the form `http://host:port` or `https://host:port`; none for any other form.
std::optional<std::string_view> host_of(std::string_view origin) {
    const auto scheme_end = origin.find("://");
    if (scheme_end == std::string_view::npos) return std::nullopt;
    const auto scheme = origin.substr(0, scheme_end);
    if (scheme != "http" && scheme != "https") return std::nullopt;
    return host_of_authority(origin.substr(scheme_end + 3));
}

bool is_loopback_origin(std::string_view origin) {
    const auto host = host_of(origin);
    return host && is_loopback(*host);
}

}  // namespace

bool allows_origin(const std::vector<std::string>& allowed, std::string_view origin) {
    return std::ranges::any_of(allowed, [&](const std::string& one) {
        return one == kAny || one == origin || (one == kLoopback && is_loopback_origin(origin));
    });
}

std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin) {
    if (allowed.empty()) return {};
    const Header exposed{"Access-Control-Expose-Headers",
                         "Content-Range, ETag, Location, Preference-Applied, Retry-After, Server-Timing, X-Partial, "
                         "X-Plot-Seconds, X-Radius, "
                         "X-Repaired, X-Request-ID, X-Warnings, "
                         "X-Tone"};
    if (std::ranges::find(allowed, kAny) != allowed.end()) return {{"Access-Control-Allow-Origin", "*"}, exposed};
    // Prevents caches from giving the answer for one origin to another. Refusals need the header, too.
    std::vector<Header> headers{{"Vary", "Origin"}};
    if (!allows_origin(allowed, origin)) return headers;
    headers.push_back({"Access-Control-Allow-Origin", std::string(origin)});
    headers.push_back(exposed);
    return headers;
}

std::vector<Header> preflight_headers(std::string_view methods) {
    return {
        {"Access-Control-Allow-Methods", std::string(methods)},
        {"Access-Control-Allow-Headers",
         "Accept, Authorization, Content-Type, If-None-Match, If-Range, Last-Event-ID, Prefer, Range, X-Request-ID"},
        {"Access-Control-Max-Age", "86400"}};
}

bool asks_for_other_origin(const Request& request) {
    if (request.header("Origin").empty()) return false;
    if (request.method == "OPTIONS") return !request.header("Access-Control-Request-Method").empty();
    const auto site = request.header("Sec-Fetch-Site");
    return request.header("Sec-Fetch-Mode") == "cors" && !site.empty() && site != "same-origin";
}

}  // namespace ccdt::server

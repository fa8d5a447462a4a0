#include "server/http/cors.h"

#include <algorithm>

namespace ccdt::server {

std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin) {
    if (allowed.empty()) return {};
    const Header exposed{"Access-Control-Expose-Headers",
                         "ETag, Location, Preference-Applied, Retry-After, Server-Timing, X-Partial, X-Radius, "
                         "X-Repaired, X-Request-ID, X-Warnings, "
                         "X-Tone"};
    if (std::ranges::find(allowed, "*") != allowed.end()) return {{"Access-Control-Allow-Origin", "*"}, exposed};
    // Caches must not give one origin's answer to another, not even one without permission.
    std::vector<Header> headers{{"Vary", "Origin"}};
    if (std::ranges::find(allowed, origin) == allowed.end()) return headers;
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

}  // namespace ccdt::server

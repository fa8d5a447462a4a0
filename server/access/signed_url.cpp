// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/signed_url.h"

#include <algorithm>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kSignature = "signature=";
constexpr std::string_view kExpires = "expires=";

}  // namespace

HttpResult<SignedUrl> SignedUrl::parse(std::string_view resource) {
    SignedUrl url;
    url.text = resource;
    const auto mark = std::min(resource.find('?'), resource.size());
    const auto last = std::max(resource.rfind('&') + 1, mark + 1);  // npos + 1 is 0
    if (last <= resource.size() && resource.substr(last).starts_with(kSignature)) {
        url.text = resource.substr(0, last - 1);
        url.signature = resource.substr(last + kSignature.size());
    }
    auto query = url.text.substr(std::min(mark + 1, url.text.size()));
    while (!query.empty()) {
        const auto parameter = api::take_until(query, "&");
        if (!parameter.starts_with(kExpires)) {
            if (!url.options.empty()) url.options += '&';
            url.options += parameter;
            continue;
        }
        if (url.expires) return problem(400, "expires is given more than once");
        url.expires = api::parse_number<std::uint64_t>(parameter.substr(kExpires.size()));
        if (!url.expires) return problem(400, "expires must be a whole number: seconds since 1970");
    }
    return url;
}

HttpResult<std::string> SignedUrl::check(const KeyRing& keys, std::chrono::sys_seconds now) const {
    if (!signature) return problem(403, "this URL must be signed: its last parameter must be `signature`");
    const auto signer = keys.find_signer(text, *signature);
    if (!signer) return problem(403, "the signature does not match this path and query with any key of this server");
    const auto seconds = std::max<std::int64_t>(now.time_since_epoch().count(), 0);
    if (expires && static_cast<std::uint64_t>(seconds) >= *expires)
        return problem(403, "the URL has expired (expires)");
    return *signer;
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/entity_tag.h"

#include "api/text/text.h"

namespace ccdt::server {

std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name) {
    while (!if_none_match.empty()) {
        const auto tag = api::trim(api::take_until(if_none_match, ","));
        auto opaque = tag;
        if (opaque.starts_with("W/")) opaque.remove_prefix(2);
        if (opaque.size() < 2 || opaque.front() != '"' || opaque.back() != '"') continue;
        opaque = opaque.substr(1, opaque.size() - 2);
        if (opaque.ends_with("-gzip")) opaque.remove_suffix(5);
        if (opaque == name) return tag;
    }
    return std::nullopt;
}

Response not_modified(std::string_view tag) {
    Response response;
    response.status = 304;
    response.tag = tag;
    return response;
}

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

#include "server/http/http.h"

namespace ccdt::server {

/// Finds the entity tag `name` in an If-None-Match header (RFC 9110, 13.1.2). Also matches the weak tag and the tag of
/// the gzip coding (`-gzip`). `*` does not match.
/// @returns  the tag as written in the header, with its quotes; none if the header does not contain it
std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name);

/// Makes a 304 answer for a client that has already stored the answer with this tag.
Response not_modified(std::string_view tag);

}  // namespace ccdt::server

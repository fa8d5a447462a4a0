// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

#include "server/http/http.h"

namespace ccdt::server {

/// Finds the tag of the answer `name` in an If-None-Match header. The tag may be weak or strong, and of any content
/// coding of the answer (RFC 9110, 13.1.2). `*` does not match.
/// @returns  the tag as it appears in the header; none if it is not there
std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name);

/// Makes a 304 for a client that already has the answer with this tag.
Response not_modified(std::string_view tag);

}  // namespace ccdt::server

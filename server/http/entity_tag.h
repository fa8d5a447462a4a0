#pragma once

#include <optional>
#include <string_view>

#include "server/http/http.h"

namespace ccdt::server {

/// Finds the tag in an If-None-Match header that names an answer, weakly or strongly and in any of its codings
/// (RFC 9110, 13.1.2). A star names none.
/// @returns  the tag as it stands there
std::optional<std::string_view> find_tag(std::string_view if_none_match, std::string_view name);

/// Answers those who have the answer of that tag: 304.
Response not_modified(std::string_view tag);

}  // namespace ccdt::server

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http.h"

namespace ccdt::server {

/// Headers that let pages of other origins read an answer.
/// @param allowed  origins, or `*` for all; empty: none
/// @param origin   of the page that asks; empty: no browser, or a page of our own
std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin);

/// Headers that let them ask, in the answer to an OPTIONS.
std::vector<Header> preflight_headers(std::string_view methods);

}  // namespace ccdt::server

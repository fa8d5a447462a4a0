#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http.h"

namespace ccdt::server {

/// Whether pages of an origin may call.
/// @param allowed  origins, kLoopback, or kAny
bool allows_origin(const std::vector<std::string>& allowed, std::string_view origin);

/// Headers that let pages of other origins read an answer.
/// @param allowed  as above; empty: none
/// @param origin   of the page that asks; empty: no browser, or a page of our own
std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin);

/// Headers that let them ask, in the answer to an OPTIONS.
std::vector<Header> preflight_headers(std::string_view methods);

/// Whether a browser asks for a page of another origin, which needs our leave: before its request or, if that is simple
/// enough, by it.
bool asks_for_other_origin(const Request& request);

}  // namespace ccdt::server

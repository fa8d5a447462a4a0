// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http.h"

namespace ccdt::server {

/// Whether pages of an origin may send requests to the server and read the answers.
/// @param allowed  origins, kLoopback, or kAny
bool allows_origin(const std::vector<std::string>& allowed, std::string_view origin);

/// Makes the headers that let pages of other origins read an answer.
/// @param allowed  as for allows_origin(); empty: no other origin
/// @param origin   origin of the calling page; empty: not a browser, or one of our own pages
std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin);

/// Makes the headers that answer an OPTIONS preflight. They permit pages of other origins to send requests.
/// @param methods  permitted methods, separated by commas
std::vector<Header> preflight_headers(std::string_view methods);

/// Whether a browser sends this request for a page of another origin, as a preflight or as a simple request. Such
/// requests need permission.
bool asks_for_other_origin(const Request& request);

}  // namespace ccdt::server

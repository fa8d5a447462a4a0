// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http.h"

namespace ccdt::server {

/// Whether pages of an origin may send requests to this server and read the answers.
/// @param allowed  origins, kLoopback, or kAny
bool allows_origin(const std::vector<std::string>& allowed, std::string_view origin);

/// Makes the headers that let pages of other origins read an answer.
/// @param allowed  see allows_origin(); empty: no other origin
/// @param origin   value of the Origin header; empty if a page of this server or a program other than a browser sent
///                 the request
std::vector<Header> cors_headers(const std::vector<std::string>& allowed, std::string_view origin);

/// Makes the headers of the answer to a CORS preflight (OPTIONS). They permit the request that will follow.
/// @param methods  permitted methods, separated by commas
std::vector<Header> preflight_headers(std::string_view methods);

/// Whether a browser sent this request for a page of another origin. Such a request is a CORS preflight or the actual
/// CORS request.
bool asks_for_other_origin(const Request& request);

}  // namespace ccdt::server

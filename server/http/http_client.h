// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/http/hosts.h"
#include "server/http/message.h"

namespace ccdt::server {

/// Checks the URL of another server to which this server may connect, and returns its origin.
/// Errors (Malformed): the text is not an http or https URL of visible ASCII characters, has credentials or a fragment,
/// has more than 1024 characters, or names an origin that `hosts` does not permit. The message contains only the host.
Result<Origin> check_target(const std::string& url, const TargetHosts& hosts);

/// Sends a POST request, and returns the status of its answer.
///
/// Follows no redirects and uses no proxies. The permission of the address is checked when the connection is opened, so
/// the name cannot change to another address between a check and its use (DNS rebinding).
/// @param url      checked by check_target() with the same hosts
/// @param timeout  limit of the whole exchange, including the look-up of the name
/// @param stop     ends the exchange early, after up to a second
/// Errors: Unavailable if no answer was received. The message states the cause, without the URL.
Result<int> post(const std::string& url, const std::vector<Header>& headers, const std::string& body,
                 const TargetHosts& hosts, std::chrono::milliseconds timeout, const std::stop_token& stop);

}  // namespace ccdt::server

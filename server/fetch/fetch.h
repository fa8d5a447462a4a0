// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "server/http/hosts.h"
#include "server/http/problem.h"

namespace ccdt::server {

/// Limits of fetching a file.
struct FetchLimits {
    std::size_t max_bytes = 0;
    std::chrono::milliseconds timeout{};  ///< limit of the whole fetch, except that looking up a name may take longer
    int max_redirects = 3;
};

/// Fetches a file from another host.
///
/// The server itself looks up the name, checks the address, and connects to it, so that the name cannot change to
/// another address between the check and its use (DNS rebinding). The program ccdt-fetcher gets the connection, and
/// exchanges and parses messages. It is confined like a decoder, and can use nothing else. Each redirect is checked
/// like the first URL.
/// @param origins   permitted origins and addresses
/// @param reserve   reserves memory for a file; called once, before the file arrives, with its size, or with
///                  `limits.max_bytes` if the size is unknown
/// @param given_up  whether the file is no longer wanted; called repeatedly
/// Problems: 400 the URL, or that of a redirect, is not permitted; 413 the file is too large; 422 the host did not send
/// the file; 503 the program cannot be started; those of `reserve`.
HttpResult<std::string> fetch(std::string url, const TargetHosts& origins, const FetchLimits& limits,
                              const std::function<HttpResult<void>(std::size_t bytes)>& reserve,
                              const std::function<bool()>& given_up);

}  // namespace ccdt::server

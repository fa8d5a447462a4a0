// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <netdb.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "server/http/hosts.h"
#include "server/http/problem.h"

namespace ccdt::server {

/// Limits of fetching a file.
struct FetchLimits {
    std::size_t max_bytes = 0;
    std::chrono::milliseconds timeout{};  ///< limit of the whole fetch
    int max_redirects = 3;
};

/// Looks up the addresses of a host, like getaddrinfo().
using Resolver = std::function<int(const char* host, const char* port, const addrinfo* wanted, addrinfo** found)>;

/// Fetches a file from another host.
///
/// The server itself looks up the name, checks the address, and connects to it, so that the name cannot change to
/// another address between the check and its use (DNS rebinding). The program ccdt-fetcher gets the connection, and
/// exchanges and parses messages. It is confined like a decoder, and can use nothing else. Each redirect is checked
/// like the first URL. The look-up of a name has no limit of its own, so it runs in a thread that may outlive the
/// fetch.
/// @param origins   permitted origins and addresses
/// @param reserve   reserves memory for a file; called once, before the file arrives, with its size, or with
///                  `limits.max_bytes` if the size is unknown
/// @param given_up  whether the file is no longer wanted; called repeatedly
/// @param slot      kept until the threads of look-ups have ended, too, by which the caller limits their number
/// Problems: 400 the URL, or that of a redirect, is not permitted; 413 the file is too large; 422 the host did not send
/// the file; 503 the program cannot be started; those of `reserve`.
HttpResult<std::string> fetch(std::string url, const TargetHosts& origins, const FetchLimits& limits,
                              const std::function<HttpResult<void>(std::size_t bytes)>& reserve,
                              const std::function<bool()>& given_up, const std::shared_ptr<void>& slot,
                              const Resolver& resolve = getaddrinfo);

}  // namespace ccdt::server

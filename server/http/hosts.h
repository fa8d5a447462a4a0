// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::server {

/// List entry for all hosts or origins of this machine.
inline constexpr std::string_view kLoopback = "loopback";

/// List entry for all hosts or origins.
inline constexpr std::string_view kAny = "*";

/// Whether a host always means this machine: `localhost`, 127.0.0.1, ::1 and similar.
/// @param host  a name in lower case or an address, without brackets
bool is_loopback(std::string_view host);

/// Removes the port from an authority, `host` or `host:port`, and the brackets from an address.
/// @returns  none if the authority is malformed
std::optional<std::string_view> host_of_authority(std::string_view authority);

/// Whether requests for an authority, as in a Host header, are answered. Requests without an authority are always
/// answered.
///
/// A stranger's page can reach a server on loopback by a name of the stranger's domain that resolves to 127.0.0.1 (DNS
/// rebinding). The browser considers such a request as going to the page's own origin. The server recognises it by the
/// name in Host.
/// @param allowed  hosts in lower case without port and brackets, kLoopback, or kAny
bool allows_host(const std::vector<std::string>& allowed, std::string_view authority);

}  // namespace ccdt::server

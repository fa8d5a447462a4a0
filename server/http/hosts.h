#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::server {

/// Entry of a list of hosts or origins that stands for all those of this machine alone.
inline constexpr std::string_view kLoopback = "loopback";

/// Entry of a list of hosts or origins that stands for all.
inline constexpr std::string_view kAny = "*";

/// Whether a host always means this machine: `localhost`, 127.0.0.1, ::1 and their like.
/// @param host  a name in small letters or an address, without brackets
bool is_loopback(std::string_view host);

/// Takes the port off an authority, `host` or `host:port`, and the brackets off an address.
/// @returns  none if the authority is malformed
std::optional<std::string_view> host_of_authority(std::string_view authority);

/// Whether requests for an authority, as in a Host header, are answered; those for none always are.
///
/// A page of a stranger reaches a server on loopback by a name of the stranger's whose address becomes 127.0.0.1 (DNS
/// rebinding): to the browser that is the page's own origin. The name in Host tells such a request from others.
/// @param allowed  hosts in small letters without port and brackets, kLoopback, or kAny
bool allows_host(const std::vector<std::string>& allowed, std::string_view authority);

}  // namespace ccdt::server

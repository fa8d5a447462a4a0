// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/ip_address.h"

namespace ccdt::server {

/// Entry of a list of hosts or origins that stands for all loopback names and addresses.
inline constexpr std::string_view kLoopback = "loopback";

/// Entry of a list of hosts or origins that permits every host or origin.
inline constexpr std::string_view kAny = "*";

/// Whether a host always means this machine: `localhost`, 127.0.0.1, ::1 and similar.
/// @param host  a name in lower case or an address, without brackets
bool is_loopback(std::string_view host);

/// Removes the port from an authority, `host` or `host:port`, and the brackets from an address.
/// @returns  none if the authority is malformed
std::optional<std::string_view> host_of_authority(std::string_view authority);

/// Whether the server answers requests that are addressed to an authority (`host` or `host:port`). An empty authority
/// is always allowed.
///
/// Prevents DNS rebinding: a foreign page can reach a server on loopback by a name of the page's own domain that
/// resolves to 127.0.0.1. The browser treats the request as same-origin, but Host contains the foreign name.
/// @param allowed  hosts in lower case without port and brackets, kLoopback, or kAny
bool allows_host(const std::vector<std::string>& allowed, std::string_view authority);

/// Returns a host in lower case, without the brackets of an address; none if the text has a port, or is neither a name
/// nor an address nor kAny. `*` stands for no part of a name.
std::optional<std::string> parse_host(std::string_view text);

/// The scheme, host and port of a URL.
struct Origin {
    std::string scheme;  ///< http or https
    std::string host;    ///< as parse_host() returns it
    std::string port;    ///< a number
};

/// The hosts to which the server may connect on behalf of clients.
struct TargetHosts {
    std::vector<std::string> names;   ///< hosts that URLs may name, or `scheme://host:port`
    std::vector<IpNetwork> networks;  ///< addresses that these hosts may have although they are not public

    /// Parses origins such as `https://pictures.example:8443`, hosts, and networks such as `10.0.0.0/8`, separated by
    /// commas. A host stands for all its origins. A host that is an address is also a network.
    /// @returns  none if the text is malformed, or consists only of networks
    static std::optional<TargetHosts> parse(std::string_view text);

    /// Whether URLs may name an origin. The address to which the server connects must be permitted, too.
    bool permits(const Origin& origin) const;
    bool permits(const IpAddress& address) const;
};

}  // namespace ccdt::server

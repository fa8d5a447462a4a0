// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "server/http/ip_address.h"
#include "server/http/message.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// Proxies whose information about their clients is trusted.
struct TrustedProxies {
    std::vector<IpNetwork> networks;
    bool unix_socket = false;  ///< any peer on a Unix socket is a trusted proxy

    bool include(const Peer& peer) const;
};

/// Finds the client of a request by the addresses that proxies write to X-Forwarded-For or Forwarded (RFC 7239).
///
/// Each proxy appends the address of its client to the addresses that it received. The search starts with the peer. As
/// long as the current address belongs to a trusted proxy, the search goes on to the address before it. So addresses
/// written by an untrusted client are never used. A malformed, `unknown` or hidden address ends the search; the proxy
/// that wrote it then counts as the client. A proxy that sets one of the two headers forwards the other one unchanged.
/// If both are present, they must name the same client; otherwise the peer is returned.
Peer client_of(const Request& request, const Peer& peer, const TrustedProxies& proxies);

}  // namespace ccdt::server

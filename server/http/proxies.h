#pragma once

#include <vector>

#include "server/http/ip_address.h"
#include "server/http/message.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// Proxies that are believed when they tell for whom they ask.
struct TrustedProxies {
    std::vector<IpNetwork> networks;
    bool unix_socket = false;  ///< whoever connects over a Unix socket is one

    bool include(const Peer& peer) const;
};

/// Finds the client of a request by the addresses that proxies leave in X-Forwarded-For or Forwarded (RFC 7239).
///
/// Each proxy adds whom it was asked by, behind what it was told, and only its word counts: starting with the peer, as
/// long as an address is a trusted proxy's, the one before it is looked at. So whoever is no trusted proxy is believed
/// nothing, and invents only addresses that are not reached. An address that is malformed, `unknown` or hidden ends the
/// search at the proxy that wrote it. A proxy that sets one of the headers passes the other one on as it came: if both
/// come they must name the same client, or the peer is taken.
Peer client_of(const Request& request, const Peer& peer, const TrustedProxies& proxies);

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "server/http/ip_address.h"
#include "server/http/message.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// Proxies whose headers about their clients are trusted.
struct TrustedProxies {
    std::vector<IpNetwork> networks;
    bool unix_socket = false;  ///< any peer on a Unix socket is a trusted proxy

    bool include(const Peer& peer) const;
};

/// Finds the client of a request from the addresses in X-Forwarded-For or Forwarded (RFC 7239).
///
/// Each proxy appends the address of its client to the header. The search starts with the peer and follows the header
/// from its end. It stops at the first address that is not a trusted proxy, so that addresses written by an untrusted
/// client are never used. It also stops at a malformed, `unknown` or hidden address; the proxy that wrote it then
/// counts as the client. A proxy that sets one of the headers forwards the other unchanged, so an untrusted client may
/// have written it. If the headers name different clients, the peer is therefore returned.
Peer client_of(const Request& request, const Peer& peer, const TrustedProxies& proxies);

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "server/http/problem.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// The PROXY header, in which a proxy names its client at the beginning of a connection.
struct ProxyHeader {
    enum class State {
        None,     ///< the connection begins with other bytes
        Partial,  ///< more bytes are needed to decide
        Whole,
    };
    State state = State::None;
    std::size_t size = 0;        ///< size of a whole header [bytes]
    std::optional<Peer> client;  ///< none: the proxy connected on its own behalf, or the client has no IP address
};

/// Parses the PROXY header from the first bytes of a connection.
///
/// Supports versions 1 and 2, for TCP over IPv4 and IPv6. Skips further fields of version 2.
/// Problem (400): a header that begins like one of these versions and then violates it.
/// Source: The PROXY protocol, versions 1 & 2 (HAProxy Technologies, 2020), sections 2.1 and 2.2.
HttpResult<ProxyHeader> parse_proxy_header(std::string_view received);

}  // namespace ccdt::server

#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "server/http/problem.h"
#include "server/http/sockets.h"

namespace ccdt::server {

/// The header by which a proxy that passes bytes on tells, at the beginning of a connection, who connected to it.
struct ProxyHeader {
    enum class State {
        None,     ///< the connection begins with something else
        Partial,  ///< more bytes are needed to tell
        Whole,
    };
    State state = State::None;
    std::size_t size = 0;        ///< in bytes, of a whole one
    std::optional<Peer> client;  ///< none: the proxy speaks for itself, or the client has no address
};

/// Reads the header from the first bytes of a connection.
///
/// Of both versions, for TCP over IPv4 and IPv6; what else version 2 may hold, such as the client's certificate, is
/// skipped. Problem (400): a header that begins as one and goes on in any other way.
/// Source: The PROXY protocol, versions 1 & 2 (HAProxy Technologies, 2020), sections 2.1 and 2.2.
HttpResult<ProxyHeader> parse_proxy_header(std::string_view received);

}  // namespace ccdt::server

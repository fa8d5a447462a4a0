// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::server {

/// Address and credentials of a Redis server.
struct RedisAddress {
    std::string host = "localhost";
    std::string port = "6379";
    bool encrypted = false;  ///< TLS
    std::string user;        ///< empty: the default user
    std::string password;    ///< empty: none
    int database = 0;

    /// Parses redis://[[user]:password@]host[:port][/database], or rediss:// for TLS. %XX is decoded.
    /// Errors (Malformed): another form, or an address of Redis Sentinel. The message does not contain the password.
    static Result<RedisAddress> parse(std::string_view text);

    /// Returns the host and port, for messages.
    std::string name() const { return host + ':' + port; }
};

}  // namespace ccdt::server

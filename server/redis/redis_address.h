#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::server {

/// Where a Redis is, and as whom to speak with it.
struct RedisAddress {
    std::string host = "localhost";
    std::string port = "6379";
    bool encrypted = false;  ///< TLS
    std::string user;        ///< empty: the default one
    std::string password;    ///< empty: none
    int database = 0;

    /// Reads redis://[[user]:password@]host[:port][/database], rediss:// for TLS. User and password may have %XX.
    /// Errors (Malformed): it is none, or Sentinel's. The message does not show the password.
    static Result<RedisAddress> parse(std::string_view text);

    /// Host and port, for people.
    std::string name() const { return host + ':' + port; }
};

}  // namespace ccdt::server

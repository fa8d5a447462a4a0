// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include "server/http/http_library.h"

namespace ccdt::server::test {

/// Reads the body of a request whose head was read from the connection, as a server does, and sends no answer.
inline HttpResult<std::string> read_body(Connection& connection, Request head, std::size_t limit) {
    HttpResult<std::string> body;
    Response response;
    bool last = false;
    process_request(connection, head, response, last, [&](const HttpResult<void>& dispatched) {
        body = dispatched.and_then([&] { return connection.read_body(head, limit); });
        response.status = kClientGone;
    });
    return body;
}

}  // namespace ccdt::server::test

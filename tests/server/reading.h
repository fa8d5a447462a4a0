// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include "server/http/http_library.h"

namespace ccdt::server::test {

/// Calls `handle` for a request whose head was read from the connection, like HttpServer, so that `handle` can read the
/// body. Writes no answer.
/// @param handle  as in process_request()
inline void process_without_answer(Connection& connection, Request& head, const Handle& handle) {
    Response response;
    bool last = false;
    process_request(connection, head, response, last, [&](const HttpResult<void>& dispatched) {
        handle(dispatched);
        response.status = kClientGone;
    });
}

/// Reads the body of a request whose head was read from the connection, like HttpServer.
inline HttpResult<std::string> read_body(Connection& connection, Request head, std::size_t limit) {
    HttpResult<std::string> body;
    process_without_answer(connection, head, [&](const HttpResult<void>& dispatched) {
        body = dispatched.and_then([&] { return connection.read_body(head, limit); });
    });
    return body;
}

}  // namespace ccdt::server::test

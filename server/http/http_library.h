// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>

#include "server/http/connection.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Maximum number of requests on one connection.
constexpr std::size_t kRequestsPerConnection = 10'000;

/// Handles a request: sets the `response` and `last` that process_request() was given.
/// @param dispatched  a problem if cpp-httplib refused a checked request with a known method
using Handle = std::function<void(const HttpResult<void>& dispatched)>;

/// Processes a request with cpp-httplib 0.11.4: calls `handle` once, then writes the response. Only this function's
/// source file includes the library.
///
/// The library parses the head, dispatches the request by its method, decodes the body and writes the answer. It never
/// reads the socket. Its input is the checked head, rewritten so that the library parses it as parse_head() does,
/// followed by the body that Connection has checked and framed again. If Connection refused the head, the library's
/// input is an empty line, which it refuses. tests/fuzz/http_library.cpp compares the two parsers.
///
/// The table lists our own code that replaces parts of the library. The second column describes the library, from
/// measurements (its pool of 8 threads, two cores, loopback) or its source:
///
/// | our own | the library |
/// |---|---|
/// | threads and deadlines: http_server.h, connection.h | with 40 clients that send nothing, a ping waits for 24 s |
/// | checks of heads: http.h | takes 93 MB for 200,000 headers; accepts `Content-Length: 10abc`, and two lengths |
/// | checks of bodies: connection.h | reads 500 MB of chunks at a limit of 1 MB; accepts chunks without a line end |
/// | pipelined requests: connection.h | answers one of three that arrive at once; parses unread bodies as requests |
/// | 100 Continue: connection.h | sends it even if the body is not wanted |
/// | targets and queries: http.h | refuses a second `?`; takes `z=b=c` for `c`; decodes `%u` |
/// | multipart: multipart.h | loses parts if a boundary arrives in two pieces; takes 29 s for a form of 0.8 MB |
/// | no ranges | takes 2 GB for 2,000 ranges of a 1 MB answer |
/// | compression: compression.h | takes 4.1 s for 2 MB of JSON (brotli at its best), for which gzip needs 0.2 s |
/// | routing: routes.h | needs 4.6 MB of stack for a regex on a path of 8 kB; answers 404 for 405 |
/// | listening: sockets.h | has a backlog of 5 clients; shares its port with any second server |
/// | TCP_NODELAY: http_server.cpp | takes 44 ms for a small answer on a kept connection without it, 0.04 ms with it |
/// | shutdown: http_server.h | drops its queue, and waits 4 s for an idle connection |
///
/// @param request   request whose head the connection has read; its method is empty if the head is invalid. The
///                  library's method and headers replace those of `request` before `handle` is called
/// @param response  set by `handle`. Its body is moved out. If sending fails, its status becomes kClientGone or 500
/// @param last      whether the connection serves no further request; set by `handle`, or if memory ran out
/// @returns         false if the client did not receive the whole answer
bool process_request(Connection& connection, Request& request, Response& response, bool& last, const Handle& handle);

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "server/http/connection.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Writes answers with cpp-httplib 0.11.4, which is included in this class' source file only.
///
/// cpp-httplib writes the status line with its phrase, the headers in order, Content-Length, Keep-Alive and Connection,
/// and the body unless the method is HEAD. Its only entry point, `process_request`, first reads a request. We give it a
/// request line with nothing but the method (HEAD or not), the only part of a request that affects writing. The router
/// of the library is never reached. A hook removes two headers that the library adds: Accept-Ranges, and Content-Length
/// in answers that must not have it.
///
/// Everything else is our own code, because of these measurements of the library (its pool of 8 threads, two cores,
/// loopback):
///
/// | our own | the library |
/// |---|---|
/// | threads and deadlines: http_server.h, connection.h | with 40 clients that send nothing, a ping waits for 24 s |
/// | reading heads: http.h | takes 93 MB for 200,000 headers; accepts `Content-Length: 10abc`, and two lengths |
/// | reading bodies: connection.h | reads 500 MB of chunks at a limit of 1 MB; parses unread bodies as requests |
/// | pipelined requests: connection.h | answers one of three that arrive at once |
/// | no ranges | takes 2 GB for 2,000 ranges of a 1 MB answer |
/// | compression: compression.h | takes 4.1 s for 2 MB of JSON (brotli at its best), for which gzip needs 0.2 s |
/// | routing: routes.h | needs 4.6 MB of stack for a regex on a path of 8 kB; answers 404 for 405 |
/// | listening: sockets.h | has a backlog of 5 clients; shares its port with any second server |
/// | TCP_NODELAY: http_server.cpp | takes 44 ms for a small answer on a kept connection without it, 0.04 ms with it |
/// | streams: http_server.cpp | ends the program if the provider of a body throws |
/// | shutdown: http_server.h | drops its queue, and waits 4 s for an idle connection |
class AnswerWriter {
public:
    /// @param idle      time-out of the connection between two requests
    /// @param requests  limit of requests on one connection
    /// The connection must outlive this object.
    AnswerWriter(Connection& connection, std::chrono::milliseconds idle, std::size_t requests);
    ~AnswerWriter();

    AnswerWriter(const AnswerWriter&) = delete;
    AnswerWriter& operator=(const AnswerWriter&) = delete;

    /// Writes an answer, except for a streamed body. Moves the body out of the response; the other members stay.
    ///
    /// @param last  whether this is the connection's last request; set if memory ran out and a 500 was written
    /// @returns     false if the client did not accept the whole answer
    bool write(const Request& request, Response& response, bool& last);

private:
    class Writer;
    const std::unique_ptr<Writer> writer_;
};

}  // namespace ccdt::server

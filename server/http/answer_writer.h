#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "server/http/connection.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Writes answers by cpp-httplib 0.11.4, which nothing but this file's source includes.
///
/// cpp-httplib does: the status line with its phrase, the headers in their order, Content-Length, Keep-Alive and
/// Connection, the body unless HEAD asked. Its only way in, `process_request`, reads a request first: it gets one line
/// that tells whether it is HEAD, which is all of a request that writing depends on, and its router is never reached.
/// Accept-Ranges, which it adds for HEAD, and the Content-Length of answers that have none are left out at its hook.
///
/// All else is ours, for what the library did when it was measured (its pool of 8 threads, two cores, loopback):
///
/// | ours | because the library's own |
/// |---|---|
/// | threads and deadlines: http_server.h, connection.h | let 40 silent clients keep a ping waiting for 24 s |
/// | reading heads: http.h | held 93 MB for 200,000 headers; took `Content-Length: 10abc`, and two lengths |
/// | reading bodies: connection.h | took 500 MB in chunks at a limit of 1 MB; ran unread bodies as the next request |
/// | requests in a row: connection.h | answered one of three that came at once |
/// | no ranges | took 2 GB for 2,000 ranges of a 1 MB answer |
/// | compression: compression.h | spent 4.1 s on 2 MB of JSON (brotli at its best), which gzip needs 0.2 s for |
/// | rows of routes: routes.h | needs 4.6 MB of stack for an expression on a path of 8 kB; answers 404 for 405 |
/// | listening: sockets.h | queues 5 clients; shares its port with any second server |
/// | TCP_NODELAY: http_server.cpp | takes 44 ms for a small answer on a kept connection without it, 0.04 ms with it |
/// | streams: http_server.cpp | ends the program if what provides a body throws |
/// | ending: http_server.h | drops what it has queued, and waits 4 s for an idle connection |
class AnswerWriter {
public:
    /// @param idle      how long the connection is kept between two requests
    /// @param requests  at most so many on one connection
    /// The connection must outlive it.
    AnswerWriter(Connection& connection, std::chrono::milliseconds idle, std::size_t requests);
    ~AnswerWriter();

    AnswerWriter(const AnswerWriter&) = delete;
    AnswerWriter& operator=(const AnswerWriter&) = delete;

    /// Writes all of an answer but a body that streams. Takes its body and leaves the rest.
    ///
    /// @param last  no further request on this connection; set if there was too little memory, and a 500 was written
    /// @returns     false if the client did not take all of it
    bool write(const Request& request, Response& response, bool& last);

private:
    class Writer;
    const std::unique_ptr<Writer> writer_;
};

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"

namespace ccdt::server {

struct Header {
    std::string name;
    std::string value;
};

/// The head of a request and the framing of its body.
struct Request {
    std::string method;
    std::string target;           ///< as sent
    std::string resource;         ///< path and query as sent, without scheme and host
    std::string path;             ///< percent-decoded
    std::string query;            ///< query as sent, without the question mark
    std::string authority;        ///< `host:port` of the target, or else the Host header; empty: none
    std::vector<Header> headers;  ///< in the order received, values as sent
    std::optional<std::uint64_t> content_length;
    bool chunked = false;
    bool is_http_1_0 = false;
    bool keep_alive = true;  ///< the client permits more requests on this connection
    bool expects_continue = false;

    /// Returns the value of the first header that is named `name`, ignoring case; empty if there is none.
    std::string_view header(std::string_view name) const;

    /// Whether a body follows the head, even an empty one.
    bool is_framed() const { return chunked || content_length.has_value(); }
};

/// Durations of the stages of a request, in milliseconds.
struct Stages {
    double queue = 0;
    api::Timings work;
};

/// Numbers of sites and pixels that were computed for an answer.
struct Computed {
    std::size_t sites = 0;
    std::size_t pixels = 0;
};

/// Facts about how a request was answered, for the log and the metrics.
struct Record {
    std::string request_id;
    std::string_view route;  ///< path of the route that answered; empty: none
    std::string key;         ///< name of the client's API key; empty: none
    std::string signer;      ///< name of the key that signed the URL; empty: none
    std::string cause;       ///< cause of an internal failure, or doubt about an answer
    Stages stages;
    std::string_view cancelled;  ///< why a computation was cancelled: client_gone, deadline or shutdown
    std::optional<Computed> computed;
    bool cached = false;  ///< the answer was taken from the cache
};

/// Sends a piece of a body immediately.
/// @returns  false if nothing more can be sent to the client
using Send = std::function<bool(std::string_view piece)>;

/// Produces a body and sends it piece by piece. Adds the outcome to the record.
/// @returns  false if the body is incomplete; the connection is then closed, so that the client notices
using Stream = std::function<bool(const Send& send, Record& record)>;

/// Status for the log if the client has closed the connection. It is never sent.
constexpr int kClientGone = 499;

/// An answer to a request.
struct Response {
    int status = 200;
    std::vector<Header> headers;
    std::string media_type;
    std::string body;
    Stream stream;                      ///< null: `body` has the whole body; not called for HEAD requests
    std::optional<std::size_t> length;  ///< length of a streamed body, if it is known
    std::string coding;                 ///< content coding of the body; empty: none
    std::string tag;                    ///< entity tag; a strong tag refers to the uncompressed body; empty: none
    std::shared_ptr<const void> lease;  ///< memory reservation, released when the answer has been sent
    Record record;
};

}  // namespace ccdt::server

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

/// The head of a request, and how its body is framed.
struct Request {
    std::string method;
    std::string target;           ///< as sent
    std::string resource;         ///< path and query as sent, without scheme and host
    std::string path;             ///< percent-decoded
    std::string query;            ///< as sent, without the request mark
    std::string authority;        ///< host and port that are asked: of the target, else of Host; empty: none is named
    std::vector<Header> headers;  ///< in order, values as sent
    std::optional<std::uint64_t> content_length;
    bool chunked = false;
    bool is_http_1_0 = false;
    bool keep_alive = true;  ///< the client wants to send more on this connection
    bool expects_continue = false;

    /// Value of the first header of that name, in any case; empty if there is none.
    std::string_view header(std::string_view name) const;

    /// Whether a body follows, if only an empty one.
    bool is_framed() const { return chunked || content_length.has_value(); }
};

/// Time that a request took, in milliseconds.
struct Stages {
    double queue = 0;
    api::Timings work;
};

/// Amounts that were computed for an answer.
struct Computed {
    std::size_t sites = 0;
    std::size_t pixels = 0;
};

/// Facts about how a request was answered, for log and figures.
struct Record {
    std::string request_id;
    std::string_view route;  ///< the path of what answered; empty: nothing did
    std::string key;         ///< the name of the API key that the client showed; empty: none
    std::string signer;      ///< the name of the key that signed the URL; empty: none
    std::string cause;       ///< of a failure of ours
    Stages stages;
    std::string_view cancelled;  ///< why a computation was given up: client_gone, deadline or shutdown
    std::optional<Computed> computed;
    bool cached = false;  ///< it was computed before
};

/// Sends a piece of a body at once.
/// @returns  false if the client takes nothing any more
using Send = std::function<bool(std::string_view piece)>;

/// Sends a body while it comes about, and adds to the record what becomes of it.
/// @returns  whether what was sent is all of it, unless the client takes nothing any more; if not, the connection ends
///           so that the client knows
using Stream = std::function<bool(const Send& send, Record& record)>;

/// Status of an answer whose client has left: nothing is sent, and the log shows it.
constexpr int kClientGone = 499;

/// An answer as it goes over the wire.
struct Response {
    int status = 200;
    std::vector<Header> headers;
    std::string media_type;
    std::string body;
    Stream stream;                      ///< null: the body is there; not called for HEAD
    std::optional<std::size_t> length;  ///< of a body that streams, if it is known
    std::string coding;                 ///< in which the body is compressed; empty: not
    std::string tag;                    ///< entity tag, of a strong one before compression; empty: none
    std::shared_ptr<const void> lease;  ///< of memory, to be given back when the answer has been sent
    Record record;
};

}  // namespace ccdt::server

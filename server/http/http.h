#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "api/options.h"

namespace ccdt::server {

struct Header {
    std::string name;
    std::string value;
};

/// The head of a request, and how its body is framed.
struct Request {
    std::string method;
    std::string target;           ///< as sent
    std::string path;             ///< percent-decoded
    std::string query;            ///< as sent, without the question mark
    std::vector<Header> headers;  ///< in order, values as sent
    std::optional<std::uint64_t> content_length;
    bool chunked = false;
    bool is_http_1_0 = false;
    bool keep_alive = true;  ///< the client wants to send more on this connection
    bool expects_continue = false;

    /// Value of the first header of that name, in any case; empty if there is none.
    std::string_view header(std::string_view name) const;

    /// A body follows, if only an empty one.
    bool is_framed() const { return chunked || content_length.has_value(); }
};

/// Where a request's time went, in milliseconds.
struct Stages {
    double queue = 0;
    api::Timings work;
};

/// How much was computed for an answer.
struct Computed {
    std::size_t sites = 0;
    std::size_t pixels = 0;
};

/// Sends a piece of a body at once.
/// @returns  false if the client takes nothing any more
using Send = std::function<bool(std::string_view piece)>;

struct Response {
    int status = 200;
    std::string media_type;
    std::string body;
    std::function<void(const Send&)> stream;  ///< sends the body while it comes about; not called for HEAD
    std::string coding;                       ///< in which the body is compressed; empty: not
    std::string tag;                          ///< entity tag, of a strong one before compression; empty: none
    std::vector<Header> headers;
    std::string request_id;
    std::string key;    ///< the name of the API key that the client showed; empty: none
    std::string cause;  ///< of a failure of ours; for the log only
    Stages stages;
    std::string_view route;      ///< the path of what answered; empty: nothing did
    std::string_view cancelled;  ///< why a computation was given up: client_gone, deadline or shutdown
    std::optional<Computed> computed;
    bool cached = false;                ///< it was computed before
    std::shared_ptr<const void> lease;  ///< of memory, to be given back when the answer has been sent
    bool deliver = true;                ///< false: the client has left
};

/// A request that is refused for the way it was sent.
struct Fault {
    int status = 400;
    std::string detail;
    std::vector<Header> headers = {};
};

template <class T>
using Received = tl::expected<T, Fault>;

inline tl::unexpected<Fault> fault(int status, std::string detail, std::vector<Header> headers = {}) {
    return tl::unexpected<Fault>(Fault{status, std::move(detail), std::move(headers)});
}

/// Reads a request's head, from the request line to the empty line, both included.
///
/// Stricter than most servers, since two that read the same bytes differently can be played against each other:
/// lines end in CRLF, names are tokens, there is one Content-Length of digits or one `Transfer-Encoding: chunked`
/// but not both. The target is a path, a URL of `http` or `https` with a host, or of OPTIONS `*`.
Received<Request> parse_head(std::string_view head);

/// Reads the line before a chunk, without its end: the chunk's size in bytes, and extensions, which are ignored.
/// Fault (400): anything but what RFC 9112, section 7.1, lets a client send; more than 16 digits.
Received<std::uint64_t> parse_chunk_size(std::string_view line);

/// What is wrong with a line after the last chunk, without its end: no well-formed field, or one that nobody may learn
/// of so late, such as a length (400).
std::optional<Fault> find_trailer_fault(std::string_view line);

/// What is wrong with a request that can be read: no Host or several (400), an expectation that is not understood
/// (417).
std::optional<Fault> find_fault(const Request& request);

/// Whether a Prefer header (RFC 7240) names a preference, whatever its value.
bool prefers(const Request& request, std::string_view preference);

/// The parameters of a query, in order and with their repetitions; `+` is a space.
std::vector<api::TextOption> parse_query(std::string_view query);

/// The type and subtype of a Content-Type, in small letters.
std::string media_type(std::string_view content_type);

/// Value of a parameter such as `boundary` in `multipart/form-data; boundary="x"`; empty if there is none.
std::string header_parameter(std::string_view value, std::string_view name);

bool equals_ignoring_case(std::string_view a, std::string_view b);

/// The phrase that belongs to a status.
std::string_view status_phrase(int status);

}  // namespace ccdt::server

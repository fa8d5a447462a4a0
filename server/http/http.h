#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"
#include "server/http/problem.h"

namespace ccdt::server {

/// Reads a request's head, from the request line to the empty line, both included.
///
/// Stricter than most servers, since two that read the same bytes differently can be played against each other:
/// lines end in CRLF, names are tokens, there is one Content-Length of digits or one `Transfer-Encoding: chunked`
/// but not both. The target is a path, a URL of `http` or `https` with a host, or of OPTIONS `*`.
HttpResult<Request> parse_head(std::string_view head);

/// Reads the line before a chunk, without its end: the chunk's size in bytes, and extensions, which are ignored.
/// Problem (400): anything but what RFC 9112, section 7.1, lets a client send; more than 16 digits.
HttpResult<std::uint64_t> parse_chunk_size(std::string_view line);

/// Checks a line after the last chunk, without its end.
/// Problem (400): no well-formed field, or one that nobody may learn of so late, such as a length.
HttpResult<void> check_trailer(std::string_view line);

/// Checks a request whose head can be read.
/// Problems: no Host, several values of a field that has one, such as Authorization (400), an expectation that is not
/// understood (417).
HttpResult<void> check_request(const Request& request);

/// Whether a Prefer header (RFC 7240) names a preference, whatever its value.
bool prefers(const Request& request, std::string_view preference);

/// The parameters of a query, in order and with their repetitions; `+` is a space.
std::vector<api::TextOption> parse_query(std::string_view query);

/// Encodes a name or value of a query so that `parse_query` gives it back, whatever it holds.
std::string encode_percent(std::string_view text);

/// The type and subtype of a Content-Type, in small letters.
std::string media_type(std::string_view content_type);

/// Value of a parameter such as `boundary` in `multipart/form-data; boundary="x"`; empty if there is none, or
/// more than one.
std::string header_parameter(std::string_view value, std::string_view name);

bool equals_ignoring_case(std::string_view a, std::string_view b);

std::string in_small_letters(std::string_view text);

/// The phrase that belongs to a status.
std::string_view status_phrase(int status);

}  // namespace ccdt::server

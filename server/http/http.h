// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"
#include "server/http/problem.h"

namespace ccdt::server {

/// Parses the head of a request, from the request line to the empty line, including both.
///
/// Stricter than most servers, because an attacker can exploit two servers that parse the same bytes differently. Lines
/// end in CRLF. Names are tokens. There is at most one framing header: a Content-Length of digits, or
/// `Transfer-Encoding: chunked`. The target is a path, an `http` or `https` URL with a host, or `*` for OPTIONS.
HttpResult<Request> parse_head(std::string_view head);

/// Parses the line before a chunk, without its CRLF. Returns the chunk's size in bytes, and ignores extensions.
/// Problem (400): anything that RFC 9112, section 7.1, forbids; more than 16 digits.
HttpResult<std::uint64_t> parse_chunk_size(std::string_view line);

/// Checks a trailer: a line after the last chunk, without its CRLF.
/// Problem (400): a malformed field, or a field that must not be a trailer, such as Content-Length.
HttpResult<void> check_trailer(std::string_view line);

/// Checks the headers of a parsed request.
/// Problems: no Host (400), a repeated field that must be single (400), an unsupported expectation (417).
HttpResult<void> check_request(const Request& request);

/// Finds a preference in the Prefer headers (RFC 7240). header_parameter() returns its parameters.
/// @returns  the preference with its value and parameters, as sent
std::optional<std::string_view> find_preference(const Request& request, std::string_view preference);

/// Whether the Prefer headers contain a preference, regardless of its value.
inline bool prefers(const Request& request, std::string_view preference) {
    return find_preference(request, preference).has_value();
}

/// Removes the text up to the first separator outside quotes from `text`, and returns it.
/// @returns  none if a quote is not closed
std::optional<std::string_view> take_unquoted(std::string_view& text, char separator);

/// Returns the decoded parameters of a query in order, including repeated ones; `+` becomes a space.
std::vector<api::TextOption> parse_query(std::string_view query);

/// Removes a parameter from a query.
/// @returns  its decoded value; none if the query does not have it. A repeated parameter counts as the last one
std::optional<std::string> take_parameter(std::string& query, std::string_view name);

/// Percent-encodes a name or value of a query. `parse_query` restores any bytes.
std::string encode_percent(std::string_view text);

/// Returns `type/subtype` of a Content-Type in lower case, without parameters.
std::string media_type(std::string_view content_type);

/// Returns the value of a parameter, such as `boundary` in `multipart/form-data; boundary="x"`, without quotes. Empty
/// if the parameter is missing or repeated.
std::string header_parameter(std::string_view value, std::string_view name);

bool equals_ignoring_case(std::string_view a, std::string_view b);

std::string to_lower_case(std::string_view text);

/// Returns the reason phrase of a status, such as "Not Found" for 404.
std::string_view status_phrase(int status);

}  // namespace ccdt::server

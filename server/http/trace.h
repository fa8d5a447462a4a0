// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

namespace ccdt::server {

/// The distributed trace of a request. The trace id has 32 hexadecimal digits, the id of the calling operation has 16.
struct Trace {
    std::string_view id;
    std::string_view parent;
};

/// Parses a `traceparent` header; none if it is malformed. The views point into `header`.
/// Source: W3C Trace Context, section 3.2; later versions may append fields, which are ignored.
std::optional<Trace> parse_traceparent(std::string_view header);

/// Returns the fields of a `traceparent` header that all versions have, for storage; empty if the header is malformed.
std::string_view whole_traceparent(std::string_view header);

}  // namespace ccdt::server

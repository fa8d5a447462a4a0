#pragma once

#include <optional>
#include <string_view>

namespace ccdt::server {

/// The distributed trace that a request belongs to, in hexadecimal.
struct Trace {
    std::string_view id;
    std::string_view parent;
};

/// Reads a `traceparent` header; none if it is not well formed. The trace refers to the header.
/// Source: W3C Trace Context, section 3.2; versions to come may append fields, which are ignored.
std::optional<Trace> parse_traceparent(std::string_view header);

/// What a `traceparent` header has in all versions, to be kept and parsed again; empty if it is not well formed.
std::string_view whole_traceparent(std::string_view header);

}  // namespace ccdt::server

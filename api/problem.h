#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Writes the body of an error answer, application/problem+json (RFC 9457).
///
/// @param status    HTTP status, repeated in the body
/// @param title     the status' own phrase
/// @param instance  identifies this occurrence: urn:request:ID
/// The detail is that of the error and the others that came with it. Adds `errors: [{pointer, detail}]`, of those which
/// name a field. Bytes that are not UTF-8 are replaced.
std::string problem_json(int status, std::string_view title, const Error& error, std::string_view instance);

}  // namespace ccdt::api

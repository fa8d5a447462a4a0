// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::api {

/// Returns the HTTP status of an answer that reports an error.
int http_status(ErrorCode code);

/// Writes the body of an error answer, application/problem+json (RFC 9457).
///
/// @param status    HTTP status, repeated in the body
/// @param title     reason phrase of the status
/// @param error     the first error; its `others` are reported as well
/// @param instance  URI that identifies the request, urn:request:ID; may be empty
/// The member `detail` joins the messages of all errors. The member `errors: [{pointer, detail}]` lists the errors that
/// name a field. Bytes that are not UTF-8 are replaced.
std::string problem_json(int status, std::string_view title, const Error& error, std::string_view instance);

}  // namespace ccdt::api

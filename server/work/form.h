#pragma once

#include <vector>

#include "core/result.h"
#include "server/http/multipart.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Finds the fields of the form in a request's body, according to its content type.
/// @returns  empty if the body is not a form
/// Errors (Malformed): those of parse_multipart.
Result<std::vector<FormPart>> find_fields(const ComputeRequest& request);

/// Converts a request with a form to one with a picture. The part `image` or `file` becomes the body; the other fields
/// are added to the query. Other requests stay as they are.
///
/// @param fields  the fields of this request
/// Errors (Malformed): no picture, or several.
Result<void> take_apart(ComputeRequest& request, const std::vector<FormPart>& fields);

}  // namespace ccdt::server

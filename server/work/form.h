#pragma once

#include <string_view>
#include <vector>

#include "core/result.h"
#include "server/http/multipart.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Finds the fields of the form that a request's body is, by its content type.
/// @returns  none if it is no form
/// Errors (Malformed): those of parse_multipart.
Result<std::vector<FormPart>> find_fields(const ComputeRequest& request);

/// Makes of a request with a form the same request with a body: the part of that name or `file` becomes the body, the
/// other fields are added to the query. What is no form stays as it is.
///
/// @param fields  of that request
/// @param part    `image`, or what else the path calls it
/// Errors (Malformed): no such part, or several.
Result<void> take_apart(ComputeRequest& request, const std::vector<FormPart>& fields, std::string_view part = "image");

}  // namespace ccdt::server

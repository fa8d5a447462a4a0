#pragma once

#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/http/multipart.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Names the answer to a request before it is computed: different requests have different ones, and so
/// have servers of other limits or versions. The same picture and options in a form have one, whatever its boundary.
///
/// @param fields  of the request's form, if it is one
/// @returns       24 characters that may stand in an entity tag
/// O(size of the body).
std::string name_of_answer(const ComputeRequest& request, const std::vector<FormPart>& fields,
                           const api::Limits& limits);

}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/http/multipart.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Computes a name for the answer to a request, from the request, the limits and the server's version. The name is a
/// digest, so different inputs give different names. The boundaries of a form do not change it.
///
/// @param fields  fields of the request's form, if it is one
/// @returns       24 characters that are valid in an entity tag
/// O(size of the body).
std::string name_of_answer(const ComputeRequest& request, const std::vector<FormPart>& fields,
                           const api::Limits& limits);

}  // namespace ccdt::server

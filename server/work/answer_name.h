// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/http/multipart.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Computes a name for the answer to a request before the answer exists. Different requests have different names. The
/// names also differ between servers with different limits or versions. Two forms with the same fields have the same
/// name, whatever their boundaries.
///
/// @param fields  fields of the request's form, if it is one
/// @returns       24 characters that are valid in an entity tag
/// O(size of the body).
std::string name_of_answer(const ComputeRequest& request, const std::vector<FormPart>& fields,
                           const api::Limits& limits);

}  // namespace ccdt::server

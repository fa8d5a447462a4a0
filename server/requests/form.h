// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/http/multipart.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Finds the fields of a request whose content type is multipart/form-data. A field `mesh` with a file name is a mesh
/// and gets the name `file`; without a file name, it is the option `mesh`.
/// @returns  empty if the body is not a form
/// Errors (Malformed): those of parse_multipart.
Result<std::vector<FormPart>> find_fields(const ComputeRequest& request);

/// Converts a request with a form to one with a plain body. The field named `part` or `file` becomes the body. If
/// `part` is `map` and neither field exists, the field `density` becomes the body, provided that it has a file name.
/// The other fields are added to the query. Other requests are not changed.
///
/// @param fields  result of find_fields() for this request
/// @param part    name of the field that becomes the body
/// Errors (Malformed): the form has no field for the body, or more than one.
Result<void> take_apart(ComputeRequest& request, const std::vector<FormPart>& fields, std::string_view part = "image");

}  // namespace ccdt::server

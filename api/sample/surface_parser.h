// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "api/sample/surface_request.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the names of the options.
std::vector<std::string_view> surface_options();

/// Reads a request for points on a surface.
///
/// @param file     the mesh, or the error of its header
/// @param options  options in the order of the request
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: those of `file`; Malformed for an unknown or repeated option, for a value out of range, if `sites` is
/// missing, and for a format of meshes without `mesh`; LimitExceeded for too many sites or fixed points; NotAcceptable
/// if the client accepts none of the formats. Error::field is the name of an option; for a list, the index of the
/// faulty element follows: `density/3`.
Result<SurfaceRequest> parse_surface(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                     std::string_view accept, const Limits& limits);

}  // namespace ccdt::api

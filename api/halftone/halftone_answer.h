// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/halftone/halftone_plan.h"
#include "api/halftone/halftone_request.h"
#include "api/output/body.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Writes the dots in a format: as a drawing, or as a list of points.
///
/// @param format   format of the request, or another one that can draw its dots
/// @param elapsed  computing time in milliseconds, for JSON
/// Errors: those of the format's writer; Stopped, unless the request accepts a partial result; Internal if memory runs
/// out.
Result<void> write_halftone(const HalftoneRequest& request, const PointFormat& format, const HalftonePlan& plan,
                            std::span<const Distribution> dots, double elapsed, const Control& control, Body& body);

}  // namespace ccdt::api

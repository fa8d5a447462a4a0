// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/halftone.h"
#include "api/halftone_plan.h"
#include "api/output/body.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Draws and encodes, or lists, the dots in the format that the request wants.
///
/// @param elapsed  milliseconds, for JSON
/// Errors: Stopped, unless a part is asked for; Internal if memory runs out.
Result<void> write_halftone(const HalftoneRequest& request, const HalftonePlan& plan, const PlacedDots& dots,
                            double elapsed, const Control& control, Body& body);

}  // namespace ccdt::api

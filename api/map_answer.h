// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/output/body.h"
#include "api/output/json_writer.h"
#include "api/output/point_drawing.h"
#include "api/sample.h"
#include "core/ccdt/ccdt.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Writes points in the requested format, grouped by feature: the dots of a dot map, or the points of a domain whose
/// request gives features.
///
/// @param whole  union of all features
/// @param page   page, for drawings
/// @param dots   [classes] of a dot map; otherwise one element with all points. Their features are those of the
///               request.
/// Errors: those of the format's writer; Stopped.
Result<void> write_map(const SampleRequest& request, const Domain& whole, const Page& page,
                       std::span<const ClassDots> dots, const Report& report, const Control& control, Body& body);

}  // namespace ccdt::api

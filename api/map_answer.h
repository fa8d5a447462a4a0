// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/output/body.h"
#include "api/output/json_writer.h"
#include "api/output/page.h"
#include "api/sample.h"
#include "core/ccdt/ccdt.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Writes the points of a sample in the requested format.
///
/// @param whole  domain of the points; of a dot map, the union of all features
/// @param page   page, for drawings
/// @param dots   [classes] of a dot map; otherwise one element with all points. If the request has features, the points
///               have these features.
/// Errors: those of the format's writer; Stopped.
Result<void> write_sample(const SampleRequest& request, const Domain& whole, const Page& page,
                          std::span<const ClassDots> dots, const Report& report, const Control& control, Body& body);

}  // namespace ccdt::api

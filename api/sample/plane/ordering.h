// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/geometry/domain.h"

namespace ccdt::api {

/// Puts points into the order that a request asks for. Points that are grouped by features stay grouped: each group has
/// its own path. A progressive order is computed for all points together; it gives each point a rank, and the points of
/// each group are sorted by rank. Does nothing for paths in drawings of shapes, whose writers find the paths.
/// Errors: Stopped, unless the request accepts partial results. After a stop, the order is arbitrary.
Result<void> order_points(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control);

}  // namespace ccdt::api

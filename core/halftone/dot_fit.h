// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/sized_dots.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Chooses the radii of dots such that the local mean of what is drawn is that of the picture in each channel, also
/// where the boundary of the ground cuts dots: where it does, the part of a dot beyond the boundary has the opposite
/// colour.
///
/// @param sites  [kinds] in cells, y down the rows
/// @param fit    false: each dot has the area that is planned where it lies
/// @returns      [kinds]
/// Same input, same bytes, on any executor. O(cells + sites).
std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt

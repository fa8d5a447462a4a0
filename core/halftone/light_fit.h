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

/// Chooses the radii of dots of inks such that the local mean of the light equals that of the picture.
///
/// The light of a place depends on all inks there. So the error of red, green and blue is corrected, and not that of
/// the share that each ink covers. The kinds of dots around a place share the correction such that the sum of squared
/// relative changes, weighted by what each kind covers, is least. Where two dots overlap, the light is that of both
/// sets of inks on each other.
///
/// @param plan  with kinds that are not nested; parameters and result as in size_dots()
std::vector<SizedDots> fit_light(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor);

}  // namespace ccdt

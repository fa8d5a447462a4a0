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

/// Chooses the radii of dots of inks such that the local mean of the print equals the local mean of the picture.
///
/// The light of a place depends on all inks there. So the fit corrects errors of red, green and blue, and not errors of
/// the coverage by each ink. Of all corrections by the kinds of dots around a place, the fit chooses the one with the
/// least sum of squared relative changes of area, weighted by the share that each kind covers. Where two dots overlap,
/// all inks that either dot flips are flipped.
///
/// @param plan  plan for inks, with `colours` and `wanted`
/// The other parameters and the result are those of size_dots().
std::vector<SizedDots> fit_light(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor);

}  // namespace ccdt

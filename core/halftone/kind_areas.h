// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Standard deviation, in radii of dots, of the blur of coverage. The areas of dots depend on the blurred coverage.
inline constexpr double kSurroundingsOfDots = 2;

/// Lower limit of the blurred coverage of a cell, relative to the coverage before the blur. Because of this limit, a
/// small light in a dark area is drawn as one dot instead of many tiny ones.
inline constexpr float kMinSurroundings = 0.25f;

/// Returns the area of a dot, up to a common factor, for which the pattern is least visible; see plan_two_sided().
/// @param cover       share that the dots cover, in [0, 1/2]
/// @param visibility  visibility of the dots, as computed by Visibility
float relative_area(float cover, float visibility);

/// Divides the areas of all kinds of dots by the area of the largest dot, so that the result is in [0, 1].
void normalize_areas(std::vector<KindOfDots>& kinds, Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Radius of the surroundings that dots share in showing a place, in radii of dots.
inline constexpr double kSurroundingsOfDots = 2;

/// Share of the surroundings that a place counts for at least: a small light in the dark is one dot rather than many
/// tiny ones.
inline constexpr float kLeastOfSurroundings = 0.25f;

/// Returns the area of a dot, up to a factor, that makes the pattern least visible.
/// @param cover       in (0, 1/2]
/// @param visibility  of the dots
float relative_area(float cover, float visibility);

/// Makes the areas of dots relative to that of the largest.
void normalize_areas(std::vector<KindOfDots>& kinds, Executor& executor = inline_executor());

}  // namespace ccdt

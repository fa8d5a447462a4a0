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

/// Chooses the radii of the dots such that, in each channel, the local mean of the drawing equals the local mean of the
/// picture.
/// If the boundary of the ground crosses a dot, the two parts of the dot have opposite colours.
///
/// @param sites  [kinds][dots] centres of the dots, in cells; y points down
/// @param fit    whether the areas are fitted; if not, each dot gets the area that the plan has at its centre
/// @param stop   polled once per round; after a stop, the result has the areas of the completed rounds
/// @returns      [kinds] sizes of the dots, and their grounds
/// Deterministic for any number of threads. O(cells + sites).
std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Chooses radii like size_dots(), with all lengths in pixels of the picture.
/// @param size  width and height of the picture, in pixels
std::vector<SizedDots> size_dots_in_pixels(const TwoSidedPlan& plan, Point size, std::vector<std::vector<Point>> sites,
                                           bool fit, const std::stop_token& stop = {},
                                           Executor& executor = inline_executor());

}  // namespace ccdt

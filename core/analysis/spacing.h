#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/point.h"

namespace ccdt {

/// Distances from points to the nearest other one.
struct Spacing {
    double min = 0;
    double mean = 0;
};

/// Measures nearest distances by a k-d tree, which crowds and gaps do not slow down.
///
/// @param points    [n], n >= 2, in [0, sides.x] x [0, sides.y]
/// @param sides     > 0
/// @param periodic  opposite sides are joined: distances are taken around the torus
/// Ends early, with nothing of use, if a stop is requested. O(n log n).
Spacing measure_spacing(std::span<const Point> points, Point sides, bool periodic, const std::stop_token& stop);

}  // namespace ccdt

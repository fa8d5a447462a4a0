// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <stop_token>

#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Distances from points to their nearest neighbours.
struct Spacing {
    double min = 0;
    double mean = 0;
};

/// Measures the distances of nearest neighbours by a k-d tree. Clusters and gaps do not affect the speed.
///
/// @param points    [n], n >= 2, in [0, sides.x] x [0, sides.y], and [0, sides.z] in space
/// @param sides     > 0
/// @param periodic  whether opposite sides are joined, so that distances are measured around the torus
/// @param weigh     returns the weight of a point's distance in the mean; none: all weigh the same, as they do if all
///                  weights are 0
///
/// A stop ends the measurement early; the result must not be used then. O(n log n).
using WeighDistance = std::function<double(Point point, double distance)>;
Spacing measure_spacing(std::span<const Point> points, Point sides, bool periodic, const std::stop_token& stop,
                        const WeighDistance& weigh = {});
Spacing measure_spacing(std::span<const Point3> points, Point3 sides, bool periodic, const std::stop_token& stop);

/// Measures the distances of nearest neighbours on a surface, along straight lines. Points whose normals are more than
/// 90 degrees apart are on different sides of a thin plate, so they are not neighbours.
///
/// @param points   [n], n >= 2
/// @param normals  [n] normals of the surface
///
/// Points without neighbours are left out; if all points are, both distances are infinite. A stop ends the measurement
/// early; the result must not be used then. O(n log n), if most of the nearest points are neighbours.
Spacing measure_spacing(std::span<const Point3> points, std::span<const Point3> normals, const std::stop_token& stop);

}  // namespace ccdt

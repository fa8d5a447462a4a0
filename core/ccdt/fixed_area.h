// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// The area that fixed points take from the new sites.
struct FixedArea {
    double sites = 0;  ///< capacity of the domain relative to that of each new site
    /// [fixed] capacity that each takes, relative to that of a new site: at most 1, 0 if far outside.
    std::vector<double> weights;
};

/// Converts points to the unit frame and sorts them so that neighbours are close. Drops points far outside; on a torus,
/// wraps points into the box.
/// @param points  in the domain's coordinates
std::vector<Point> to_unit_frame(const Domain& domain, std::span<const Point> points);

/// Subtracts the area of fixed points from a grid of capacities. Each point takes a disc with the capacity of a new
/// site at the local density, except for what is nearer to another fixed point. So an isolated point takes as much as a
/// site, and a cluster no more than its area and a rim. The new sites share the rest equally.
///
/// @param fixed   in the unit frame; may lie outside the domain
/// @param sites   number of new sites, >= 1
/// @param masses  [rows * columns] capacities of cells over the domain's box; reduced in place
///
/// O(cells). The nearest points are found by sweeps: Danielsson, Euclidean distance mapping, Computer Graphics and
/// Image Processing 14 (1980).
FixedArea subtract_fixed_area(const Domain& domain, std::span<const Point> fixed, std::size_t sites, int columns,
                              int rows, std::span<double> masses);

}  // namespace ccdt

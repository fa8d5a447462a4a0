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
    double sites = 0;  ///< capacity of the domain, divided by the capacity of each new site
    /// [fixed] capacity that each fixed point takes, in units of a new site's capacity: at most 1; 0 if far outside.
    std::vector<double> weights;
};

/// Converts points to the unit frame and sorts them so that neighbours are close in the order. Points far outside are
/// dropped; on a torus, points are wrapped into the box.
/// @param points  in the domain's coordinates
std::vector<Point> to_unit_frame(const Domain& domain, std::span<const Point> points);

/// Subtracts the area of fixed points from a grid of capacities. Each fixed point takes a disc with the capacity of a
/// new site at the local density, except where another fixed point is nearer. So an isolated fixed point takes as much
/// capacity as a site, and a cluster takes only the area that it covers and a rim around it. The new sites share the
/// remaining capacity equally.
///
/// @param fixed   in the unit frame; may lie outside the domain
/// @param sites   number of new sites, >= 1
/// @param masses  [rows * columns] capacities of cells over the domain's box; reduced in place
///
/// O(cells). Nearest points: Danielsson, Euclidean distance mapping, Computer Graphics and Image Processing 14 (1980).
FixedArea subtract_fixed_area(const Domain& domain, std::span<const Point> fixed, std::size_t sites, int columns,
                              int rows, std::span<double> masses);

}  // namespace ccdt

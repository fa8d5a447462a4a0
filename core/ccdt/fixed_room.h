#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Room that points which are there already take from sites to come.
struct FixedRoom {
    double sites = 0;             ///< the domain's capacity over what each site to come has of it
    std::vector<double> weights;  ///< [fixed] what each has, over what a site to come has: at most 1, 0 if far outside
};

/// Points in the unit frame of a domain, in an order in which neighbours are near, those far outside left out; on a
/// torus in its box.
/// @param points  in the domain's coordinates
std::vector<Point> to_unit_frame(const Domain& domain, std::span<const Point> points);

/// Takes from a grid's capacities what fixed points take: around each a disc that holds as much as a site to come has,
/// to each place that of its own density, but what is nearer to another fixed point is that one's. So one alone takes
/// as much as a site, and a cluster no more than its area and a rim. Sites to come have equal shares of the rest.
///
/// @param fixed   in the unit frame; also outside of the domain
/// @param sites   to come, >= 1
/// @param masses  [rows * columns] capacities of cells over the domain's box; out: what is left of them
/// O(cells). The nearest points are found by sweeps: Danielsson, Euclidean distance mapping, Computer Graphics and
/// Image Processing 14 (1980).
FixedRoom take_room(const Domain& domain, std::span<const Point> fixed, std::size_t sites, int columns, int rows,
                    std::span<double> masses);

}  // namespace ccdt

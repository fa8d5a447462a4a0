// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

struct Disc {
    Point centre;
    double radius = 0;
};

/// Erodes a domain by `distance`.
///
/// @param domain        not a torus
/// @param distance      > 0, in the domain's coordinates
/// @param indifference  approximate limit on the additional distance of the new border, in the domain's coordinates
///                      (exceptions below); 0 requires a border exact to 1 % of `distance`, at any cost
///
/// The unit frame and the bounding box do not change. The new border is at least `distance` from the old one. If
/// `indifference` is 0, the new border is at most 1 % farther: arcs around corners become circumscribed polygons, and
/// borders with detail much finer than the distance are simplified.
///
/// Errors: Unusable if nothing is left; Stopped. Deterministic. O(n log n) in practice, even for ragged borders.
///
/// If `indifference` is not 0, the new border can be much farther from the old one in two cases:
/// - by up to 40 times the indifference, if the domain has more than 50,000 corners;
/// - by up to 120 times the indifference, for any number of corners, if a quadtree of the border would need very many
///   squares.
/// In both cases the domain's edges are not intersected at all. Instead, the squares of the quadtree that the new
/// border may cross are removed as a whole, and the resulting border is simplified.
///
/// Why not GEOS' buffer of a negative distance: its arcs cut corners, and it drops detail of the border that is finer
/// than a hundredth of the distance. Both faults leave points too near to the border.
Result<Domain> inset(const Domain& domain, double distance, double indifference = 0, const std::stop_token& stop = {});

/// Returns the disc to be removed around a point of the border, in the domain's coordinates; radius 0 removes nothing.
/// The disc must vary smoothly along the border.
using DiscAround = std::function<Disc(Point)>;

/// Erodes a domain by discs around the points of its border, like the overload with a constant distance.
/// @param indifference  as for a constant distance. In addition, if there are many corners and their discs differ by
///                      less than the indifference, all discs count as equally large, which is much faster. Squares of
///                      the quadtree are removed as a whole only if all discs have a radius above 0.
Result<Domain> inset(const Domain& domain, const DiscAround& disc_around, double indifference = 0,
                     const std::stop_token& stop = {});

/// Returns the largest distance of any point of a domain from the domain's border, in the domain's coordinates. Some
/// point attains the returned distance, which is at most 1 % below the true maximum.
/// @param stop  polled regularly; a stop returns the best value so far
///
/// O(n) for each of some hundred trial points. Source: Garcia-Castellanos, Lombardo, Poles of inaccessibility, Scottish
/// Geographical Journal 123 (2007); Agafonkin, Polylabel (2016).
double largest_clearance(const Domain& domain, const std::stop_token& stop = {});

}  // namespace ccdt

#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/parallel/team.h"

namespace ccdt {

/// Orders points so that the first k of them, for any k, are spread as evenly as so many of them can be, and are
/// denser in one place than in another as all of them are.
///
/// From the last to the first, points go that are most in excess: the sum of (1 - d / r)^5 over neighbours nearer than
/// r, r being 1.7 to 2 times what neighbours would be apart if those that stay stood in a hexagonal grid, and where
/// points are denser than elsewhere as much shorter; and half of the number of points beyond their share, blurred
/// by splines of cells three such distances wide. Of two that are nearer than 0.58 of that distance one goes at once.
/// So that no part of the domain loses more than others, it is halved again and again into regions of equally many
/// points, down to 256 to 511 that are left, which else take turns.
///
/// @param domain  on a torus points are near across its sides, too; of any other only the bounding box counts
/// @param points  [n], in the domain's bounding box; they may coincide
/// @param even    whether points are as dense everywhere, and there is no border; else their own distances tell
/// @param stop    asked now and then; a stop returns a permutation that is of no use, and is no error
/// @param team    sums crowding and measures densities
/// @returns       indices [n]: a permutation
/// Same input, same bytes, by any team. O(n log n).
/// Source: Yuksel 2015, "Sample elimination for generating Poisson disk sample sets". Departures: r grows while points
/// go, rather than once an octave; long waves; the least distance; regions; the density is told by the points.
std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool even,
                                             const std::stop_token& stop = {}, Team& team = alone());

/// The same of points on the globe, in longitude and latitude, degrees: in a conformal chart around their middle.
std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop = {},
                                                      Team& team = alone());

}  // namespace ccdt

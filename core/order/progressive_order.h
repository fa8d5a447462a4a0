// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Orders points progressively: for any k, the first k points are spread as evenly as possible, with the same relative
/// density as all points.
///
/// Points are removed from the last to the first, always one with the largest excess. The excess is the sum of (1 - d /
/// r)^5 over neighbours at distances d < r, plus half of the smoothed surplus of points around it. r is 1.7 to 2 times
/// the neighbour distance in a hexagonal grid of the points that stay, scaled by the local spacing. The surplus is
/// smoothed by splines on cells three such distances wide. Of two points nearer than 0.58 of that distance, one is
/// removed at once. So that no part of the domain loses more points than others, the domain is recursively halved into
/// regions with equal numbers of points, down to 256 to 511 points left, which otherwise take turns.
///
/// @param domain    on a torus distances are periodic; of any other domain only the bounding box is used
/// @param points    [n], in the domain's bounding box; may coincide
/// @param even      whether points have the same density everywhere, without a border; else the density is measured
///                  from the points
/// @param stop      polled regularly; a stop is not an error, but the returned permutation must not be used
/// @param executor  computes crowding and densities
/// @returns         indices [n]: a permutation
///
/// Deterministic for any number of threads. O(n log n).
/// Source: Yuksel 2015, "Sample elimination for generating Poisson disk sample sets". Departures: r grows as points are
/// removed, not once per octave; long waves; the least distance; regions; the density is measured from the points.
std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool even,
                                             const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Does the same for points on the globe, in longitude and latitude, degrees, in a conformal chart around their centre.
std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop = {},
                                                      Executor& executor = inline_executor());

}  // namespace ccdt

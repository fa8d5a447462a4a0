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
/// Points are removed one after another, and the order of the result is the reverse of their removal. The next point is
/// always one with the largest excess. The excess is the sum of (1 - d / r)^5 over neighbours at distances d < r, plus
/// half of the smoothed surplus of points around the point. r is 1.7 to 2 times the neighbour distance h in a hexagonal
/// grid of the remaining points, scaled by the local spacing. The surplus is smoothed by splines on cells of width 3 h.
/// If two points are nearer to each other than 0.58 h, one of them is removed at once.
///
/// No part of the domain should lose more points than others. So the domain is recursively halved into regions with
/// equal numbers of points, of which 256 to 511 remain, and the regions lose points in turn.
///
/// @param domain    on a torus distances are periodic; of any other domain only the bounding box is used
/// @param points    [n], in the domain's bounding box; may coincide
/// @param even      whether points have the same density everywhere, without a border; otherwise the density is
///                  measured from the points
/// @param stop      polled regularly; a stop is not an error, but the returned permutation must not be used
/// @param executor  computes crowding and densities
/// @returns         indices [n]: a permutation
///
/// Deterministic for any number of threads. O(n log n).
///
/// Source: Yuksel 2015, "Sample elimination for generating Poisson disk sample sets". Departures: r grows steadily as
/// points are removed, not once per octave; the surplus, which suppresses long waves; the least distance; regions; the
/// density is measured from the points.
std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool even,
                                             const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Does the same for points on the globe, given by longitude and latitude in degrees. Uses a conformal chart around
/// their centre.
std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop = {},
                                                      Executor& executor = inline_executor());

}  // namespace ccdt

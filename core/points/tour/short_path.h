// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Orders points along a short open path, for example for a plotter.
///
/// @param points  [n], finite; may coincide
/// @param stop    polled regularly; a stop returns the current path, which is not an error
/// @returns       indices [n]: a permutation
///
/// Deterministic. About O(n log n). For random points, the path is 8 % longer than the shortest path.
/// Source: Bentley 1992, "Fast algorithms for geometric traveling salesman problems": 2-opt and Or-opt with neighbour
/// lists, and a queue instead of don't-look bits. Departures: the initial path follows Hilbert's curve, the neighbour
/// lists come from the Delaunay triangulation, and reversals of very many points are skipped.
std::vector<std::uint32_t> short_path(std::span<const Point> points, const std::stop_token& stop = {});

/// Orders points along a short closed tour, by the same steps. The way back from the last point to the first counts.
std::vector<std::uint32_t> short_tour(std::span<const Point> points, const std::stop_token& stop = {});

/// Returns the length of the path through all points in order.
double path_length(std::span<const Point> points);

}  // namespace ccdt

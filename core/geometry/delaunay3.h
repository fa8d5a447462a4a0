// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point3.h"

// Delaunay triangulation in space by CGAL, which only delaunay3.cpp includes.
namespace ccdt {

/// The numbers of the four corners of a tetrahedron. The last corner lies on the left of the triangle of the first
/// three: seen from the last one, these are counter-clockwise.
using Tetrahedron = std::array<std::uint32_t, 4>;

/// Computes the Delaunay triangulation of points in space.
/// @param points  [n <= 2^32] finite; coincident points share one vertex, which has the number of one of them
/// @param stop    polled regularly; after a stop, there are no tetrahedra
/// @returns       the tetrahedra; none if all points lie in a plane
///
/// Deterministic. O(n log n) for points that are spread evenly.
std::vector<Tetrahedron> delaunay_tetrahedra(std::span<const Point3> points, const std::stop_token& stop = {});

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/geometry/point3.h"

namespace ccdt::api {

/// Divides a polygon with n >= 3 corners into n - 2 triangles, which have its orientation. A convex polygon becomes a
/// fan around its first corner, a concave quadrilateral one around its concave corner. Other polygons are divided by
/// clipping ears, after projection along the axis that is closest to their normal. They need not be planar, but should
/// not intersect themselves.
/// @param corners    positions
/// @param triangles  receives the indices of the corners [n - 2]
///
/// Deterministic. O(n (1 + concave corners)). Source: Meisters, Polygons have ears, 1975.
void divide_polygon(std::span<const Point3> corners, std::span<std::array<std::uint32_t, 3>> triangles);

}  // namespace ccdt::api

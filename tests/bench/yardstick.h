// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "core/geometry/point.h"

namespace ccdt::bench {

/// Milliseconds that CGAL's Delaunay_triangulation_2 takes to triangulate the points once, inserted as one range.
/// What all times are compared with, in the same run on the same machine.
double delaunay_ms(std::span<const Point> points);

}  // namespace ccdt::bench

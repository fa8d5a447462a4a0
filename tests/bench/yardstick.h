// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "core/geometry/point.h"

namespace ccdt::bench {

/// Triangulates points once by CGAL's Delaunay_triangulation_2, inserted as one range, and returns the milliseconds.
/// All benchmarks are compared with this time, measured in the same run.
double delaunay_ms(std::span<const Point> points);

}  // namespace ccdt::bench

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

/// Returns the density of a shaded pear on white.
Density pear();

/// Returns the density of thin lines on white.
Density thin_lines();

/// Returns the density of strokes like those of text, on white.
Density strokes();

/// Returns a low density with a smooth, dense spot in the middle and a dense box in a corner.
Density spot_and_corner();

/// Returns the number of points in cells without density. The density covers the bounding box of the domain.
std::size_t count_on_white(const Domain& domain, const Density& density, const std::vector<Point>& points);

}  // namespace ccdt::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

/// Pictures with large white areas: a shaded body on white ground, thin lines, and strokes like those of text.
Density pear();
Density thin_lines();
Density strokes();

/// A smooth spot in the middle and a bright box at a corner, on a dim ground.
Density spot_and_corner();

/// How many points stand in cells without density; the density is stretched over the domain, which is a box.
std::size_t count_on_white(const Domain& domain, const Density& density, const std::vector<Point>& points);

}  // namespace ccdt::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/ground.h"

namespace ccdt {

/// Traces the black ground.
///
/// @returns  closed rings in cells, the first point not repeated; an even number of rings around a place means white
///           ground there, an odd number black ground. Along the picture's border rings run on the border.
/// Linear between crossings of the lines through cell centres, so within a fraction of a cell of the ground's boundary.
/// Deterministic. O(cells).
/// Source: marching squares (Lorensen, Cline 1987, in the plane); ambiguous squares by the mean of their corners.
std::vector<std::vector<Point>> outline_of(const Ground& ground);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/ground.h"

namespace ccdt {

/// Traces the boundary of the black ground.
///
/// @returns  closed rings in units of cells, without repetition of the first point. They enclose the black ground by
///           the even-odd rule. Where black ground reaches the border of the picture, the ring follows the border.
/// Within each square between four cell centres, rings are straight, so they deviate a little from the boundary.
/// Deterministic. O(cells).
/// Source: marching squares, the form of marching cubes (Lorensen, Cline 1987) in the plane. In an ambiguous square,
/// the mean of the four corners decides.
std::vector<std::vector<Point>> outline_of(const Ground& ground);

}  // namespace ccdt

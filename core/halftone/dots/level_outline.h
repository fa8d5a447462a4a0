// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point.h"
#include "core/picture/reduction.h"

namespace ccdt {

/// Traces the boundary of the area in which a function, the level, is at most 0. The level is given at the centres of
/// cells, linear between them, and constant beyond the outermost centres.
///
/// @param level  [columns * rows] finite
/// @returns      closed rings in units of cells, without repetition of the first point. They enclose the area by the
///               even-odd rule. Where the area reaches the border of the picture, the ring follows the border.
/// Within each square between four cell centres, rings are straight, so they deviate a little from the boundary.
/// Deterministic. O(cells).
/// Source: marching squares, the form of marching cubes (Lorensen, Cline 1987) in the plane. In an ambiguous square,
/// the mean of the four corners decides.
std::vector<std::vector<Point>> outline_of(std::span<const float> level, const CellGrid& cells);

/// Returns the approximate share of each cell that the rings of outline_of() enclose [columns * rows]: the mean of the
/// enclosed shares of the four squares that have a corner at the centre of the cell.
std::vector<float> outlined_shares(std::span<const float> level, const CellGrid& cells,
                                   Executor& executor = inline_executor());

}  // namespace ccdt

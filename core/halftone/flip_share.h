// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Computes the share of each cell that dots should flip: ink dots on white ground, paper dots on black ground.
///
/// For a cell that the boundary crosses, the share follows from the nearby cells that lie completely on one ground:
/// their mean share on each side of the boundary, weighted by the area of this ground in the cell. At an edge between
/// black and white, the result is 0. Where a smooth tone crosses 1/2, it is about 1/2.
///
/// @param light  [cells] in [0, 1]
/// @param white  [cells] share of white ground
/// @returns      [cells]
std::vector<float> flip_share(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                              Executor& executor = inline_executor());

/// Removes the dots from ground that is thinner than a dot. To keep the local mean, reduces the share of the dots on
/// the opposite ground next to the thin ground.
///
/// @param white   [cells] share of white ground
/// @param radius  radius of the dots, in cells
/// @param share   [cells] share that dots should flip; modified
void clear_thin_ground(const std::vector<float>& white, const CellGrid& cells, double radius, std::vector<float>& share,
                       Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Computes the share of each cell that dots should flip: ink dots on white ground, paper dots on black ground.
///
/// In a cell on one ground, the share is |light - ground|, where ground is 1 for white and 0 for black. In a cell that
/// the boundary crosses, each ground has the mean share of nearby cells that lie completely on this ground. The result
/// is the mean over the cell: 0 at an edge between black and white, about 1/2 where a smooth tone crosses 1/2.
///
/// @param light  [cells] in [0, 1]
/// @param white  [cells] share of white ground
/// @returns      [cells]
std::vector<float> flip_share(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                              Executor& executor = inline_executor());

/// Removes dots from ground that is thinner than a dot. To keep the local mean, also removes dots from the opposite
/// ground around it.
///
/// @param white   [cells] share of white ground
/// @param radius  radius of the dots, in cells
/// @param share   [cells] share that dots should flip; modified
void clear_thin_ground(const std::vector<float>& white, const CellGrid& cells, double radius, std::vector<float>& share,
                       Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Computes the share of each cell that the picture wants flipped: ink on white ground, paper on black ground.
///
/// A cell that the boundary crosses wants what the cells beside it do, on either side: nothing at an edge between black
/// and white, half of it where a smooth tone passes one half.
///
/// @param light  [cells] in [0, 1]
/// @param white  [cells] share of white ground
/// @returns      [cells]
std::vector<float> wanted_share(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                                Executor& executor = inline_executor());

/// Leaves ground that is thinner than dots without dots, and takes the error that this makes off the dots beside it,
/// which are on the other side.
///
/// @param radius  of the dots, in cells
/// @param share   [cells] that the picture wants flipped; changed
void spare_thin_ground(const std::vector<float>& white, const CellGrid& cells, double radius, std::vector<float>& share,
                       Executor& executor = inline_executor());

}  // namespace ccdt

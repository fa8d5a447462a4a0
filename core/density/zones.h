// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/density/density.h"

namespace ccdt {

/// Divides a density into zones along its steps. A step is a difference between neighbouring cells that is more than
/// twice what the slopes on both sides of it explain. It may include one cell of an intermediate value, as at the edge
/// of an antialiased shape. In a cell that holds several sites, every difference is a step. A zone is a connected set
/// of cells that no step divides. Zones that are too small for a few sites are parts of the zones around them.
///
/// @param density   not uniform
/// @param periodic  whether the first and the last cells along an axis are neighbours
/// @param sites     number of sites in the whole grid
/// @returns         zone of each cell [height * width], from 0; empty if there is only one zone
///
/// O(cells).
std::vector<std::uint32_t> find_zones(const Density& density, bool periodic, double sites);

/// Does the same in space.
/// @param voxels  number of voxels along x, y and z; their product is below 2^31
/// @param values  [voxels along z][along y][along x] densities, >= 0, not all 0
std::vector<std::uint32_t> find_zones(const std::array<std::size_t, 3>& voxels, std::span<const float> values,
                                      bool periodic, double sites);

/// Groups zones into at most 16 classes. The zones of a class have about the same density: in the order of density, a
/// new class begins where the density is more than 1.2 times the previous one. The last class has all further zones.
/// @param densities  mean density of each zone [zones], >= 0
/// @returns          numbers of the zones in each class, from the least density to the largest
std::vector<std::vector<std::uint32_t>> group_into_classes(std::span<const double> densities);

}  // namespace ccdt

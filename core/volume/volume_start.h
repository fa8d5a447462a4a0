// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point3.h"
#include "core/volume/voxel_density.h"

namespace ccdt {

/// Draws initial sites, as StartSites does in the plane. Halves the domain across its longest side into cells of equal
/// mass that hold up to four sites each, and draws the sites of each cell at random. Successive sites are near each
/// other. Deterministic. O(sites log voxels).
/// @tparam Domain  BoxDomain3 or SolidDomain
/// @param density  over the bounding box of the domain
/// @param inside   the same, but 0 outside the domain as far as its voxels are outside
template <class Domain>
std::vector<Point3> draw_start(const Domain& domain, const VoxelDensity& density, const VoxelDensity& inside,
                               std::size_t sites, std::uint64_t seed);

}  // namespace ccdt

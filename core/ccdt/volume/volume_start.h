// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/volume/voxel_density.h"
#include "core/ccdt/volume/voxel_zones.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Draws initial sites, as StartSites does in the plane. Recursively divides the domain across its longest side into
/// cells of up to four points, whose mass is proportional to their number of points, and draws the sites of each cell
/// at random. Each zone of the density, and all zones of a class together, get their number of sites within about one
/// site, except for errors of the shares of zones in cells, which are estimated by 32 random positions. Successive
/// sites are near each other. Deterministic. O(points log voxels).
/// @tparam Domain  BoxDomain3 or SolidDomain
/// @param density  over the bounding box of the domain
/// @param inside   the same, multiplied in each voxel by the share of the voxel that is in the domain
/// @param zones    of `density`
/// @param fixed    points in the domain that each take the place of a site
/// @param stop     polled for each cell; after a stop, sites are missing
/// @returns        [sites + fixed] positions in the domain; the fixed points come last
template <class Domain>
std::vector<Point3> draw_start(const Domain& domain, const VoxelDensity& density, const VoxelDensity& inside,
                               const VoxelZones& zones, std::size_t sites, std::span<const Point3> fixed,
                               std::uint64_t seed, const std::stop_token& stop);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/volume/solid.h"
#include "core/ccdt/volume/volume_construction.h"
#include "core/ccdt/volume/voxel_density.h"

namespace ccdt {

/// Distributes sites in a solid, as distribute_in_volume() does in a box. The coordinates of points are those of the
/// soup.
///
/// @param density  stretched over the bounding box of the solid
/// @param options  fixed points must be inside the solid
/// @param control  a stop returns the current sites, which is not an error
///
/// Errors: Malformed if the number of sites is out of range ("sites") or a fixed point is not inside ("fixed/N");
/// Unusable if the density is 0 everywhere in the solid ("density"); Stopped if a stop comes before all initial sites
/// are drawn. Deterministic for any number of threads. O(n log n) for n = sites + faces. With uniform density, about
/// 200 bytes per site, and 12 bytes per cell of a grid. The grid has 5.8 cells per site, divided by the share of the
/// bounding box that is inside, but at most 22 cells per site. With `keep_mesh`, 500 bytes more per site.
Result<VolumeDistribution> distribute_in_solid(const Solid& solid, const VoxelDensity& density,
                                               const VolumeOptions& options, const Control& control = {});

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/distribution.h"
#include "core/result.h"
#include "core/volume/box_domain3.h"
#include "core/volume/volume_construction.h"
#include "core/volume/voxel_density.h"

namespace ccdt {

/// Checks a domain, and the numbers and positions of points in it. Errors: those of distribute_in_volume(), except for
/// Stopped. O(fixed points).
Result<void> check_volume(const BoxDomain3& domain, const VolumeOptions& options);

/// Distributes sites in a box or a torus in space, evenly or by a density, as distribute() does in the plane:
/// relaxation of the tetrahedra's capacities alternates with pushes of near neighbours and with the removal of long
/// waves of density error.
///
/// @param density  stretched over the domain; periodic on a torus
/// @param options  fixed points must be in the domain
/// @param control  a stop returns the current sites, which is not an error
///
/// Errors: Malformed if the number of points is out of range ("sites"), a side is not positive or not finite
/// ("domain"), or a fixed point is not in the domain ("fixed/N"); Unusable if a side is shorter than a quarter of the
/// cubic root of the volume per point ("domain"); Stopped if a stop comes before all initial sites are drawn.
/// Deterministic for any number of threads. O(sites log sites). Without `keep_mesh`, 225 (box) or 240 (torus) bytes
/// per site for a million sites of uniform density in a cube.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 5, names the generalisation to space as future work.
Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control = {});

}  // namespace ccdt

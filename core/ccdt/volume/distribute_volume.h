// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/volume_construction.h"
#include "core/ccdt/volume/voxel_density.h"

namespace ccdt {

/// Returns the sides of the domain in which the points are spread, the longest of which is 1. Sides shorter than the
/// mean distance between points are lengthened to it. So the points in a thin domain are spread evenly along its long
/// sides, as in a domain as thick as one spacing.
Point3 unit_sides(Point3 sides, std::size_t points);

/// Checks a domain, and the numbers and positions of points in it. Errors: those of distribute_in_volume(), except for
/// Stopped. O(fixed points).
Result<void> check_volume(const BoxDomain3& domain, const VolumeOptions& options);

/// Distributes sites in a box or a torus in space, evenly or by a density, as distribute() does in the plane:
/// relaxation of the tetrahedra's capacities alternates with pushes of near neighbours and with the removal of long
/// waves of density error. unit_sides() tells how a thin domain is treated.
///
/// @param density  stretched over the domain; periodic on a torus
/// @param options  fixed points must be in the domain
/// @param control  a stop returns the current sites, which is not an error
///
/// Errors: Malformed if the number of points is out of range ("sites"), a side is below 1e-300 or not finite
/// ("domain"), or a fixed point is not in the domain ("fixed/N"); Stopped if a stop comes before all initial sites are
/// drawn. Deterministic for any number of threads. O(sites log sites). Without `keep_mesh`, 225 (box) or 240 (torus)
/// bytes per site for a million sites of uniform density in a cube.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 5, names the generalisation to space as future work.
Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control = {});

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/ccdt/distribution.h"
#include "core/geometry/point3.h"
#include "core/result.h"
#include "core/volume/box_domain3.h"
#include "core/volume/volume_mesh.h"
#include "core/volume/voxel_density.h"

namespace ccdt {

struct VolumeOptions {
    std::size_t sites = 0;   ///< 1 to 2^31
    std::uint64_t seed = 0;  ///< [0, 2^53)
    /// Stealthy removes all power below half the principal frequency on a torus of uniform density without fixed
    /// points. For other domains, it is the same as Best.
    Quality quality = Quality::Standard;
    bool keep_mesh = false;  ///< whether to fill VolumeDistribution::mesh
    /// Existing points in the domain, which do not move and are not among the sites. Sites keep the same distance from
    /// them as from each other. Each takes as much space as a site.
    std::vector<Point3> fixed = {};
};

struct VolumeDistribution {
    std::vector<Point3> points;  ///< [sites] in the domain; in a box, strictly inside
    /// Capacity variation of the tetrahedra before each relaxation: standard deviation over mean.
    std::vector<double> trace;
    bool stopped = false;                   ///< whether a stop ended the computation early; there is no mesh then
    std::optional<TetrahedronMesh> mesh;    ///< its vertices are the points, the fixed points, then others
    std::vector<std::uint32_t> ranks = {};  ///< [points] rank of each point in a progressive order; may be empty
};

/// Distributes sites in a box or a torus in space, evenly or by a density, as distribute() does in the plane:
/// relaxation of the tetrahedra's capacities alternates with pushes of near neighbours and with the removal of long
/// waves of density error.
///
/// @param density  stretched over the domain; periodic on a torus
/// @param control  a stop returns the current sites, which is not an error
///
/// Errors: Malformed for an option out of range, or a side or a fixed point that is not finite or not in range;
/// Unusable if a side is shorter than a quarter of the points' distance. Deterministic for any number of threads.
/// O(sites log sites), about 300 bytes per site.
/// Source: Xu, Liu, Gotsman, Gortler 2011, section 5, names the generalisation to space as future work.
Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control = {});

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/volume/tetrahedron_mesh.h"
#include "core/ccdt/volume/voxel_density.h"
#include "core/geometry/point3.h"

namespace ccdt {

struct VolumeOptions {
    /// Largest number of sites and fixed points together. Numbers of sites and of a few copies of each fit 32 bits.
    static constexpr std::size_t kMaxPoints = std::size_t{1} << 30;

    std::size_t sites = 0;   ///< >= 1
    std::uint64_t seed = 0;  ///< [0, 2^53)
    /// Stealthy removes all power below half the principal frequency on a torus of uniform density without fixed
    /// points. For other domains, it is the same as Best.
    Quality quality = Quality::Standard;
    bool keep_mesh = false;  ///< whether to fill VolumeDistribution::mesh
    /// Existing points in the domain, which do not move and do not count as sites. Sites keep the same distance from
    /// them as from each other. Each fixed point takes as much space as a site.
    std::vector<Point3> fixed = {};
};

struct VolumeDistribution {
    std::vector<Point3> points;  ///< [sites] in the domain; in a box or solid, strictly inside
    /// Capacity variation of the tetrahedra before each relaxation: standard deviation over mean.
    std::vector<double> trace;
    bool stopped = false;  ///< whether a stop ended the computation early; there is no mesh then
    /// The vertices are the points, the fixed points, then vertices on the border. The vertices of the points are up to
    /// half a spacing away from the points, which makes small dihedral angles larger.
    std::optional<TetrahedronMesh> mesh;
    std::vector<std::uint32_t> ranks = {};  ///< [points] rank of each point in a progressive order; may be empty
};

/// Checks the number of points. Errors: Malformed if it is out of range ("sites").
Result<void> check_sites(const VolumeOptions& options);

/// Distributes sites in a domain whose longest side is 1. distribute_in_volume() describes the method.
/// @tparam Domain  BoxDomain3 or SolidDomain
/// @param density  over the bounding box of the domain
/// @param inside   the same, multiplied in each voxel by the share of the voxel that is in the domain; none if the
///                 domain is its bounding box
/// @param fixed    the fixed points, in the domain's coordinates
/// @param control  a stop returns the current sites
///
/// Errors: Stopped if a stop comes before all initial sites are drawn.
template <class Domain>
Result<VolumeDistribution> construct_volume(const Domain& domain, const VoxelDensity& density,
                                            std::optional<VoxelDensity> inside, const VolumeOptions& options,
                                            std::span<const Point3> fixed, const Control& control);

}  // namespace ccdt

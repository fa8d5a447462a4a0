// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/surface_density.h"
#include "core/geometry/point3.h"

namespace ccdt {

struct SurfaceOptions {
    std::size_t sites = 0;                ///< >= 1
    std::uint64_t seed = 0;               ///< [0, 2^53)
    int iterations = 5;                   ///< 0 to 1000; with 0, the initial sites are the result
    int passes = 5;                       ///< passes per iteration, 1 to 100
    Quality quality = Quality::Standard;  ///< not Stealthy
    bool keep_mesh = false;               ///< whether to fill SurfaceDistribution::mesh
    /// Existing points, in the coordinates of the soup. Each is projected to the nearest point of the surface. They do
    /// not move and are not among the sites; sites keep the same distance from them as from each other. A point that
    /// is nearer than a quarter of the hexagonal distance to an earlier one is ignored.
    std::vector<Point3> fixed = {};
};

/// A triangulation of the sites, in the coordinates of the soup. Delaunay: see
/// SurfaceTriangulation::restore_delaunay().
struct SurfaceMesh {
    /// Sites, then fixed points that were not ignored, then vertices on borders and creases and vertices of the surface
    /// that could not be removed (see SurfaceTriangulation).
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< oriented like the surface
};

using SurfaceDistribution = BasicDistribution<SurfacePoint, SurfaceMesh>;

/// Distributes sites on a surface by Capacity-Constrained Delaunay Triangulation. Every component gets its share.
///
/// Errors: Unusable if the density is 0 everywhere; Stopped if a stop comes before the initial sites are triangulated.
/// After a later stop, the current sites are the result, with `stopped` set. The same input gives the same result for
/// any number of threads. O(n log n) for n = sites + faces, and O(n) per pass.
Result<SurfaceDistribution> distribute_on_surface(const Surface& surface, const SurfaceDensity& density,
                                                  const SurfaceOptions& options, const Control& control = {});

}  // namespace ccdt

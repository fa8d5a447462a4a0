// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/relax/triangle_goals.h"
#include "core/ccdt/surface/surface_density.h"
#include "core/ccdt/surface/surface_triangulation.h"

namespace ccdt {

/// Moves sites, one at a time, to where the capacities of the triangles around them come closest to their targets. This
/// is the coordinate descent of Relaxation (core/ccdt/relax/relaxation.h) with the goals of goals.h, in the tangent
/// plane of each site: the plane perpendicular to the mean normal of the triangles around it. Neighbours are rotated
/// into this plane, so that their distances from the site are kept. Then the site follows the surface.
///
/// Source: Xu, Hu, Gotsman, Liu 2012, "Blue noise sampling of surfaces", section 3. Departures: targets, springs and
/// over-relaxation, as in the plane; moves along the surface instead of projection to the nearest point.
class SiteRelaxation {
public:
    /// @param mesh, density  must outlive this object
    /// @param capacity       integral of the density that belongs to each site
    SiteRelaxation(SurfaceTriangulation& mesh, const SurfaceDensity& density, double capacity);

    /// Sets the goals of all triangles. Returns the capacity variation of the current mesh. O(triangles).
    /// @param in_row  as for set_goals() (core/ccdt/relax/goals.h)
    double variation(std::span<const std::uint8_t> in_row = {});

    /// Moves every free site `passes` times. The goals must have been set since edges last changed. Sites are moved in
    /// parallel; the result does not depend on the number of threads. O(sites * passes).
    /// @param stop  polled in each pass
    void pass(int passes, const std::stop_token& stop);

private:
    struct Ring;

    void move(std::uint32_t site);

    SurfaceTriangulation& mesh_;
    const SurfaceDensity& density_;
    double capacity_;
    std::vector<TriangleGoal> goals_;  ///< [triangles]
};

}  // namespace ccdt

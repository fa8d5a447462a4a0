// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/polish/first_row.h"
#include "core/polish/schedule.h"
#include "core/surface/site_masses.h"
#include "core/surface/site_relaxation.h"
#include "core/surface/surface_density.h"
#include "core/surface/surface_triangulation.h"

namespace ccdt {

/// Performs the steps of a polish on a surface (see run_schedule): pushes near sites apart, makes the capacities of the
/// triangles more equal, and removes long waves of density error by ExcessFlow, like MeshTransport in the plane. Fixed
/// sites do not move. Deterministic for any number of threads. O(sites + faces) per step.
class SitePolish {
public:
    /// All arguments must outlive this object.
    /// @param capacity  integral of the density that belongs to each site
    /// @param stop      polled in each step
    SitePolish(SurfaceTriangulation& mesh, const SurfaceDensity& density, double capacity, SiteRelaxation& relaxation,
               const std::stop_token& stop);

    void push(const Push& push);
    void equalise(int passes) { relaxation_.iterate(passes, stop_); }
    void even_out();
    void even_out_together() {}  // there is only one ink
    void restore() { mesh_.restore_delaunay(stop_); }
    /// Whether any two sites are nearer to each other than `least`, relative to the hexagonal distance. Also finds
    /// sites that no edge joins, unless they are on different sides of a thin plate. Pushes move such sites apart, too,
    /// until separate() is called.
    bool is_any_nearer(double least);
    /// Relocates one site of each pair that is_any_nearer() found and that is still much nearer than `least`. The new
    /// place is a nearby triangle with a large capacity. Does nothing after the fourth call, and limits the number of
    /// pairs: 16, and one for each 256 sites.
    void separate(double least);
    void retouch() {}
    void remove_low_frequencies() {}

private:
    bool is_near(std::uint32_t a, std::uint32_t b, double reach) const;
    std::vector<std::uint32_t> wide_triangles(std::uint32_t site) const;
    void measure_spacings();
    void apply();

    SurfaceTriangulation& mesh_;
    const SurfaceDensity& density_;
    double capacity_;
    SiteRelaxation& relaxation_;
    const std::stop_token& stop_;
    SiteMasses masses_;
    std::vector<double> spacings_;                      ///< [sites] 1 / sqrt(wanted density of sites)
    std::vector<Point3> moves_;                         ///< [sites]
    int separations_ = 0;                               ///< calls of separate()
    std::vector<std::array<std::uint32_t, 2>> joined_;  ///< pairs of near sites that an edge joins
    std::vector<std::array<std::uint32_t, 2>> facing_;  ///< other pairs of near sites
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/excess_flow.h"
#include "core/ccdt/polish/first_row.h"
#include "core/ccdt/polish/schedule.h"
#include "core/ccdt/surface/site_masses.h"
#include "core/ccdt/surface/site_relaxation.h"
#include "core/ccdt/surface/surface_density.h"
#include "core/ccdt/surface/surface_triangulation.h"

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
    void equalise(int passes) {
        restore();
        relaxation_.variation();  // sets the goals
        relaxation_.pass(passes, stop_);
        flow_.reset();
    }
    void even_out();
    void even_out_together() {}  // there is only one ink
    void restore() { mesh_.restore_delaunay(stop_); }
    /// Whether any two sites are nearer to each other than `least`, relative to the hexagonal distance, and further
    /// pushes are useful. Pushes count as useless after twelve successive calls, since the last removal of waves, that
    /// did not find fewer such pairs. Also finds sites that no edge joins, unless they are on different sides of a thin
    /// plate or on parallel sheets that are different components.
    /// The next pushes move such sites apart, too.
    bool is_any_nearer(double least);
    /// Relocates one site of each pair that is_any_nearer() found and that pushes do not separate: the distance is much
    /// less than `least`, or has hardly grown since the previous search. The new position is the middle of a nearby
    /// triangle, as far as possible from other sites. Every second call does nothing. Handles at most 16 pairs, plus
    /// one for each 256 sites. Only surfaces that are too rough for the spacing of the sites have more.
    void separate(double least);
    /// Moves apart the sites that the last call of is_any_nearer() found and that other steps cannot separate. Such
    /// sites lie at tips that are thinner than the spacing, where triangles cannot follow the surface. The sites follow
    /// the surface, but the mesh does not change. Sites beside borders and creases stay where they are, unless they are
    /// very near to another one.
    /// @returns  the new points of all sites; none if no two sites that can move are very near to each other at a tip
    std::optional<std::vector<SurfacePoint>> spread(double least) const;
    void retouch() {}
    void remove_low_frequencies() {}

private:
    struct NearPair {
        std::array<std::uint32_t, 2> sites;  ///< ascending
        double distance;                     ///< in spacings
    };

    std::vector<std::uint32_t> wide_triangles(std::uint32_t site) const;
    bool keep_apart(std::uint32_t a, std::uint32_t b) const;
    bool are_on_parallel_sheets(const SurfacePoint& from, const SurfacePoint& to) const;
    bool is_beside_border(std::uint32_t site) const;
    bool is_thin_around(std::uint32_t site) const;
    void measure_spacings();
    void apply();

    SurfaceTriangulation& mesh_;
    const SurfaceDensity& density_;
    double capacity_;
    SiteRelaxation& relaxation_;
    const std::stop_token& stop_;
    SiteMasses masses_;
    std::optional<ExcessFlow> flow_;    ///< along the edges of the mesh; rebuilt after relaxation and after relocations
    std::vector<std::uint32_t> owner_;  ///< [vertices] owners() of the mesh at that time
    std::vector<double> spacings_;      ///< [sites] 1 / sqrt(wanted density of sites)
    std::vector<Point3> moves_;         ///< [sites]
    std::optional<CellList3> cells_;    ///< positions of the sites at the last search for near pairs
    std::vector<NearPair> near_, before_;  ///< sorted pairs that the last two searches have found
    std::size_t fewest_ = 0;               ///< least number of pairs in a search since the last removal of waves
    int separations_ = 0;                  ///< calls of separate()
    int failures_ = 0;                     ///< successive searches that have not found fewer pairs than `fewest_`
};

}  // namespace ccdt

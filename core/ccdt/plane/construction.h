// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/plane/domain_mesh.h"
#include "core/ccdt/plane/start.h"
#include "core/ccdt/polish/fixed_sites.h"
#include "core/ccdt/polish/mesh_polish.h"
#include "core/ccdt/polish/support.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/goals.h"
#include "core/ccdt/relax/relaxation.h"

namespace ccdt {

/// Checks that every option is in its documented range. Errors: Malformed.
Result<void> check(const Options& options);

/// Whether a polish follows the iterations.
bool has_polish(const Options& options);

/// Builds the capacity-constrained triangulation of one density in steps: start(); iterate() while
/// has_next_iteration(); the rounds of a polish, run by the caller; finish(). After the start, collect() returns the
/// current state.
class Construction {
public:
    /// @param domain, density  must outlive this
    Construction(const Domain& domain, const Density& density, const Options& options, const Control& control);
    Construction(const Construction&) = delete;  // the relaxation refers to the mesh
    Construction& operator=(const Construction&) = delete;

    /// Draws and triangulates the initial sites.
    /// Errors: Unusable if the density is zero everywhere in the domain or the domain is too thin; Stopped.
    Result<void> start();

    /// Whether there is another iteration to run.
    bool has_next_iteration() const;
    /// Runs the passes of one iteration, then makes the triangulation Delaunay again.
    /// @returns  false after a stop
    bool iterate();

    /// Returns the object that performs the steps of the polish. After finish(), this function must not be called, and
    /// the object must not be used.
    MeshPolish& polish();
    Triangulation& mesh() { return placed_->mesh; }

    /// Makes the triangulation Delaunay, then makes its capacities more equal by `passes` passes. Called in rounds of
    /// the polish.
    void equalise(int passes);

    /// Relocates one site of each pair to a position with more space. Only for polygons.
    /// @param pairs  pairs of sites that are too close to each other
    void separate(std::span<const std::array<std::uint32_t, 2>> pairs);

    /// Ends the iterations and the polish: restores the Delaunay property, evens out narrow places, and moves sites
    /// from positions where the density is zero. Errors: as for start().
    Result<void> finish();

    Distribution collect();

    std::size_t sites() const { return options_.sites; }
    bool is_uniform() const { return density_.is_uniform(); }
    int iterations() const { return result_.iterations; }
    double variation() const { return result_.variation(); }
    /// Whether finish() placed sites in rows.
    bool has_rows() const { return !in_row_.empty(); }

private:
    bool stopping() const { return stop_.stop_requested(); }
    Result<void> choose_fixed();
    Result<DomainMesh> mesh_for(std::size_t fixed) const;
    Result<DomainMesh> triangulate_sites(std::vector<Point> first);
    double site_share() const;
    const StartSites& start_sites();
    std::vector<Point> even_start();
    double measure(const Triangulation& mesh);
    Result<bool> move_single_sites();
    Relaxation& relaxation();
    bool is_exact(int iteration) const;
    void pass_exactly(Relaxation& relaxation);
    bool resettles() const;

    const Domain& domain_;
    const Density& density_;
    Options options_;
    std::stop_token stop_;
    Executor& executor_;
    CapacityIntegral capacity_;
    Support support_;
    FixedSites fixed_;
    std::optional<DomainMesh> placed_;
    // Each of the following takes as much memory as the mesh, so it exists only while it is used.
    std::optional<StartSites> start_;
    std::optional<MeshPolish> polish_;
    std::optional<Relaxation> relaxation_;
    TriangleGoals goals_;
    std::vector<std::uint8_t> in_row_;  ///< [sites] whether a narrow place determines the site; empty: none
    Distribution result_;
};

}  // namespace ccdt

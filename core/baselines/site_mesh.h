// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/plane/domain_mesh.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/goals.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// The sites that a method moves, and their triangulation, on which capacities are measured as in distribute().
/// Contains what the methods of this folder share: the initial sites, the measurement, and the stopping rules. All
/// positions are in the unit frame.
class SiteMesh {
public:
    /// Draws and triangulates the same initial sites as distribute().
    /// @param domain, density  must outlive this
    ///
    /// Errors: those of distribute().
    static Result<SiteMesh> create(const Domain& domain, const Density& density, const Options& options,
                                   const std::stop_token& stop);

    const Domain& domain() const { return *domain_; }
    const Density& density() const { return *density_; }
    const CapacityIntegral& capacity() const { return capacity_; }
    const Triangulation& mesh() const { return mesh_; }
    Triangulation& mesh() { return mesh_; }

    std::span<const Point> sites() const { return {mesh_.points().data(), mesh_.site_count()}; }

    /// Moves all sites and restores the Delaunay property. If a site would leave the domain or come too close to its
    /// border, the site moves only half of the way, or a quarter, and so on.
    /// @param wanted  [sites] finite; on a torus, any periodic copy
    /// @returns       false, without moving any site, if the domain is too thin even for shortened moves
    ///
    /// O(sites); several times faster if the moves invert no triangle.
    bool move(std::span<const Point> wanted);

    /// Calls `step` repeatedly. Ends when `step` returns false because nothing moves, when options.iterations are
    /// completed, when the variation is below options.tolerance, or when a stop is requested. A step interrupted by a
    /// stop may leave the sites unmoved.
    /// @returns  the sites, with the capacity variation after each iteration as in distribute()
    Distribution iterate(const Options& options, const Control& control, const std::function<bool()>& step);

private:
    SiteMesh(const Domain& domain, const Density& density, DomainMesh empty);

    double measure();
    Point end_of_way(Point from, Point to) const;
    bool is_sound() const;
    bool keeps_margin() const;
    bool insert_all(std::span<const Point> from, std::span<const Point> to);
    bool insert(Triangulation& mesh, std::uint32_t site, Point from, Point to) const;

    const Domain* domain_;
    const Density* density_;
    CapacityIntegral capacity_;
    DomainMesh empty_;  ///< mesh without sites
    Triangulation mesh_;
    std::vector<double> capacities_;   ///< [triangles]
    std::vector<TriangleGoal> goals_;  ///< [triangles] targets and weights
};

}  // namespace ccdt

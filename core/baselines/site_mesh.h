#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/capacity_integral.h"
#include "core/ccdt/ccdt.h"
#include "core/ccdt/domain_mesh.h"
#include "core/ccdt/goals.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Sites that a method moves, in the triangulation that distribute() measures them by. It holds what the methods of
/// this folder share: the start, the measure, when to end. All places are in the unit frame.
class SiteMesh {
public:
    /// Draws and triangulates the start that distribute() has.
    /// @param domain, density  must outlive this
    /// Errors: those of distribute().
    static Result<SiteMesh> create(const Domain& domain, const Density& density, const Options& options,
                                   const std::stop_token& stop);

    const Domain& domain() const { return *domain_; }
    const Density& density() const { return *density_; }
    const CapacityIntegral& capacity() const { return capacity_; }
    const Triangulation& mesh() const { return mesh_; }
    Triangulation& mesh() { return mesh_; }

    /// Places of the sites [sites].
    std::span<const Point> sites() const { return {mesh_.points().data(), mesh_.site_count()}; }

    /// Moves all sites and makes the triangulation Delaunay again. A site that would leave the domain, or come too
    /// close to its border, goes half of its way, or a quarter, and so on.
    /// @param wanted  [sites] finite; on a torus any copy
    /// @returns  false, and nothing moves, where the domain is too thin even so
    /// O(sites), several times quicker where no triangle is turned over on the way.
    bool move(std::span<const Point> wanted);

    /// Calls `step` until it returns false, for having nothing more to move, or options.iterations are done, or the
    /// variation is below options.tolerance, or a stop is asked for. A step during which one is asked for may leave
    /// the sites where they were.
    /// @returns  the sites and, as after each iteration of distribute(), the capacity variation
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
    DomainMesh empty_;  ///< without sites
    Triangulation mesh_;
    std::vector<double> capacities_;   ///< [triangles]
    std::vector<TriangleGoal> goals_;  ///< [triangles]
};

}  // namespace ccdt

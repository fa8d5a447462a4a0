// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/first_row.h"
#include "core/ccdt/polish/fixed_sites.h"
#include "core/ccdt/polish/local_spacing.h"
#include "core/ccdt/polish/mesh_transport.h"
#include "core/ccdt/polish/stealth.h"
#include "core/ccdt/polish/support.h"
#include "core/ccdt/polish/transport.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/move_guard.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Performs the steps of a polish on the sites of one triangulation. Pushes move near neighbours apart. Transport
/// removes the long waves of density error that the iterations leave.
class MeshPolish {
public:
    /// Prepares the transforms that remove long waves in boxes and on tori.
    /// @param domain, density  must outlive this object
    /// @param capacity         capacity of the domain, in units of the capacity of a density cell with the value 1;
    ///                         unused if the density is uniform
    /// @param sites            number of free sites
    /// @param support          of the density; unused if the density is uniform; must outlive this object
    /// @param fixed            existing points; `fixed.positions` are the mesh's last sites
    /// @param stop             polled regularly; after a stop the object must not be used
    /// @param executor         runs the steps; must outlive this object
    MeshPolish(const Domain& domain, const Density& density, double capacity, std::size_t sites, const Support& support,
               FixedSites fixed = {}, const std::stop_token& stop = {}, Executor& executor = inline_executor());

    const Density& density() const { return density_; }

    /// Returns 1 / sqrt(wanted density of sites) around a point.
    double spacing(Point p) const;

    /// Evens out the initial sites before they are triangulated, so that sites can cross gaps in the density. Does
    /// nothing for a uniform density, or in polygons.
    void even_out_start(std::span<Point> sites, const std::stop_token& stop);

    /// Releases most of the memory until the next step.
    void release_memory();

    /// Prepares the steps that move sites: lists the edges between sites. Must be called again after edges change.
    void begin(const Triangulation& mesh);

    /// Moves neighbours apart if they are too near to each other, and adds the moves `pushed`. Like all steps, keeps
    /// the triangles counter-clockwise, but loses the Delaunay property.
    /// @param reach   distance below which neighbours are pushed, relative to the hexagonal distance
    /// @param push    share of the missing distance by which each of the two sites moves
    /// @param pushed  [sites] moves caused by other inks; may be empty
    void push_apart(Triangulation& mesh, double reach, double push, std::span<const Point> pushed,
                    const std::stop_token& stop);

    /// Whether any two sites are nearer to each other than `least`, relative to the hexagonal distance. In polygons,
    /// two near sites are not always joined by an edge: they can face each other across a gap in the domain or around a
    /// vertex of the border. This function also finds such pairs, and the next calls of push_apart() move them apart.
    bool find_nearer(const Triangulation& mesh, double least);

    /// Returns the pairs of near sites that find_nearer() has found for the same `least`, in ascending order. Omits
    /// a pair if one of its sites is the first site of an earlier pair in the result. Drops cached data of the mesh,
    /// since the caller may relocate sites.
    std::vector<std::array<std::uint32_t, 2>> near_pairs(const Triangulation& mesh, double least);

    /// Removes long waves of density error. In polygons, does so only if the density is smooth and there are no fixed
    /// points.
    void even_out(Triangulation& mesh, const std::stop_token& stop);

    /// Removes the power of low frequencies. The domain must be a torus of uniform density that is wide enough
    /// (Stealth::fits()) and has no fixed sites. Does nothing once all this power is negligible
    /// (Stealth::kNegligiblePower).
    void remove_low_frequencies(Triangulation& mesh, const std::stop_token& stop);

    /// Moves the sites. @param moves  [sites]
    void move(Triangulation& mesh, std::span<const Point> moves);

private:
    void list_edges(const Triangulation& mesh, std::size_t block, std::vector<std::uint32_t>& others);
    std::vector<std::array<std::uint32_t, 2>> joined_within(const Triangulation& mesh, double half_reach) const;
    bool is_nearer(const Triangulation& mesh, std::uint32_t a, std::uint32_t b, double half_reach) const;
    void find_facing(const Triangulation& mesh, double half_reach);
    void push_off_others(const Triangulation& mesh, double half_reach, double push);
    void measure_spacings(const Triangulation& mesh);
    double spacing_of(std::uint32_t site) const { return spacings_.empty() ? even_spacing_ : spacings_[site]; }
    void apply(Triangulation& mesh);
    Point inside(Point p) const;
    template <class Spacing>
    Point allowed(Point from, Point to, Spacing&& spacing) const;

    Executor& executor_;
    const Domain& domain_;
    const Density& density_;
    FixedSites fixed_;
    std::optional<CellList> others_;  ///< fixed points without a vertex
    std::optional<Transport> transport_;
    std::optional<MeshTransport> mesh_transport_;  ///< for polygons, created when first needed
    std::optional<Stealth> stealth_;               ///< created when first needed
    std::optional<LocalSpacing> local_;            ///< present if the density varies and there is no transport_
    const Support& support_;
    FirstRow row_;  ///< for polygons
    /// [levels][blocks] Half-edges between sites, each listed for the smallest block that contains both of its sites.
    std::vector<std::vector<std::vector<std::uint32_t>>> edges_;
    std::vector<std::array<std::uint32_t, 2>> facing_;  ///< pairs of near sites that no edge joins
    /// [sites] moves; once they are applied, the positions before the moves.
    std::vector<Point> moves_;
    std::vector<double> spacings_;  ///< [sites] local spacings; empty if the density of a box or torus is uniform
    double even_spacing_ = 0;       ///< the spacing if the density is uniform
    MoveGuard guard_;               ///< renewed when the edges change
};

}  // namespace ccdt

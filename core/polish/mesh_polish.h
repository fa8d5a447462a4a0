#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"
#include "core/polish/cell_list.h"
#include "core/polish/first_row.h"
#include "core/polish/fixed_sites.h"
#include "core/polish/local_spacing.h"
#include "core/polish/mesh_transport.h"
#include "core/polish/stealth.h"
#include "core/polish/support.h"
#include "core/polish/transport.h"

namespace ccdt {

/// Steps of a polish on the sites of one triangulation: near neighbours are pushed apart, and what is left of long
/// waves of density error, most of it along the border and where the density is steep, is transported away.
class MeshPolish {
public:
    /// Prepares the transforms that even out long waves in boxes and on tori.
    /// @param domain, density  must outlive this
    /// @param capacity         of the domain, in units of one cell with density 1; not used if the density is uniform
    /// @param sites            that are free
    /// @param fixed            the mesh's last sites are these, if there are any
    /// @param stop             asked now and then; leaves what is of no use
    /// @param team             does the steps; must outlive this
    MeshPolish(const Domain& domain, const Density& density, double capacity, std::size_t sites, FixedSites fixed = {},
               const std::stop_token& stop = {}, Team& team = alone());

    const Density& density() const { return density_; }

    /// 1 / sqrt(density of the sites that are wanted) around a point.
    double spacing(Point p) const;

    /// Evens out first sites, which no triangulation binds yet: they may cross gaps in the density.
    /// Nothing happens for a uniform density.
    void even_out_start(std::span<Point> sites, const std::stop_token& stop);

    /// Gives back what most of the memory is for until the next step.
    void rest();

    /// Lists the edges between sites. Comes before the other steps, and again after all that changes edges.
    void begin(const Triangulation& mesh);

    /// Moves neighbours that are nearer than they should be apart, and sites as others push them. Of this step and the
    /// following ones all triangles stay counter-clockwise; the Delaunay property is lost.
    /// @param reach   over the distance of neighbours in a hexagonal grid
    /// @param push    share of what is missing by which each of the two moves
    /// @param pushed  [sites] or empty: how far others push each site
    void push_apart(Triangulation& mesh, double reach, double push, std::span<const Point> pushed,
                    const std::stop_token& stop);

    /// Tells whether any two sites are nearer than so much, over the distance of neighbours in a hexagonal grid. In
    /// polygons such two may stand on two shores, or a vertex of the border between them, so that no edge joins them:
    /// the next pushes push them apart, too.
    bool find_nearer(const Triangulation& mesh, double least);

    /// Returns the pairs of sites that find_nearer() has found; each site is the first of one pair at most. Drops what
    /// is cached of the mesh, since either site of a pair may be relocated.
    std::vector<std::array<std::uint32_t, 2>> take_nearer(const Triangulation& mesh, double least);

    /// Undoes long waves of density error. Nothing happens in polygons if the density is not smooth.
    void even_out(Triangulation& mesh, const std::stop_token& stop);

    /// Silences the low frequencies of a torus of uniform density that is wide enough for its sites, none of them
    /// fixed; nothing happens once they are silent.
    void silence(Triangulation& mesh, const std::stop_token& stop);

    /// @param moves  [sites]
    void move(Triangulation& mesh, std::span<const Point> moves);

    /// Takes sites where there is no density to the nearest place with some.
    /// @returns  whether there were any
    bool clear_gaps(std::span<Point> sites) const;

private:
    void list_edges(const Triangulation& mesh, std::size_t block, std::vector<std::uint32_t>& others);
    std::vector<std::array<std::uint32_t, 2>> joined_within(const Triangulation& mesh, double half_reach) const;
    bool is_nearer(const Triangulation& mesh, std::uint32_t a, std::uint32_t b, double half_reach) const;
    void find_facing(const Triangulation& mesh, double half_reach);
    void push_off_others(const Triangulation& mesh, double half_reach, double push);
    void measure_spacings(const Triangulation& mesh);
    double spacing_of(std::uint32_t site) const { return spacings_.empty() ? even_spacing_ : spacings_[site]; }
    void apply(Triangulation& mesh);
    void take_back(Triangulation& mesh);
    double area_before(const Triangulation& mesh, std::uint32_t triangle) const;
    bool is_sound(const Triangulation& mesh, std::uint32_t triangle, double area) const;
    Point inside(Point p) const;
    template <class Spacing>
    Point allowed(Point p, Spacing&& spacing) const;

    Team& team_;
    const Domain& domain_;
    const Density& density_;
    FixedSites fixed_;
    std::optional<CellList> others_;  ///< of the fixed sites
    std::optional<Transport> transport_;
    std::optional<MeshTransport> mesh_transport_;  ///< in polygons, once it is asked for
    std::optional<Stealth> stealth_;               ///< once it is asked for
    std::optional<LocalSpacing> local_;            ///< where a density varies and transport_ does not know it
    Support support_;
    FirstRow row_;  ///< in polygons
    /// Half-edges between sites, of each block those within it but not within a smaller one [levels][blocks].
    std::vector<std::vector<std::vector<std::uint32_t>>> edges_;
    std::vector<std::array<std::uint32_t, 2>> facing_;  ///< near sites that no edge joins
    std::vector<Point> moves_;                          ///< [sites] and, once they are made, where these were before
    std::vector<double> spacings_;                      ///< [sites]; empty if all have the same
    double even_spacing_ = 0;                           ///< that one
    double largest_area_ = 0;                           ///< of all triangles before a move, doubled
};

}  // namespace ccdt

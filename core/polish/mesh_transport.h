#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"
#include "core/polish/first_row.h"
#include "core/polish/graph_solver.h"

namespace ccdt {

/// Evens out long waves in domains of any shape, as Transport does in boxes and on tori: finds how far the sites'
/// density, smoothed over a few of them, is off the wanted one, and small moves of all sites that undo it.
///
/// What sites are too many is measured on a grid, and flows off along the edges of their triangulation, whose
/// conductances are those of linear finite elements. So nothing flows across the border, nor from one part of the
/// domain to another: each wants as many sites as it has. For densities that vary little from one site to the next.
///
/// Source: as Transport, in whose place Laplace's equation is solved on the mesh; core/README.md derives it.
class MeshTransport {
public:
    /// @param mesh     trimmed, not a torus'
    /// @param density  of the sites that are wanted
    /// O(sites + vertices of the border), and the grid's cells: at most 64 for each site.
    MeshTransport(const Domain& domain, const Density& density, const Triangulation& mesh);

    /// Finds the share of the error, in sites, that falls to each site, as ErrorGrid::at() has it.
    using Measure = std::function<void(std::span<const Point> sites, std::span<double> errors)>;

    /// Tells whether what is too many may flow along the edge between two sites.
    using Passes = std::function<bool(std::uint32_t, std::uint32_t)>;

    /// The same, of sites whose error is measured otherwise, and that do not all follow each other.
    /// O(sites + vertices of the border).
    MeshTransport(const Triangulation& mesh, Measure measure, const Passes& passes);

    /// Computes the moves of a round. Sites do not come nearer to the border than half a row, unless they are.
    /// @param mesh      as it was, or with edges flipped and sites moved since by less than a spacing or two
    /// @param spacings  [sites] 1 / sqrt(density of the sites that are wanted)
    /// @param moves     out [sites], none longer than 0.35 of the spacing there
    /// @param stop      asked now and then
    /// @returns         false if it was stopped: the moves are of no use
    /// O(sites + vertices of the border).
    bool displacements(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves,
                       const std::stop_token& stop = {});
    /// @param row  of the mesh as it is
    bool displacements(const Triangulation& mesh, const FirstRow& row, std::span<const double> spacings,
                       std::span<Point> moves, const std::stop_token& stop = {});

private:
    void find_errors(const Triangulation& mesh);
    void flow(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves) const;

    Team& team_;
    GraphSolver solver_;
    Measure measure_;
    std::vector<double> error_, potential_;  ///< [sites]
    std::vector<std::uint32_t> part_of_;     ///< [sites]: that edges link, of those that pass
    std::vector<double> sums_;               ///< [parts] of the error
    std::vector<double> counts_;             ///< [parts] of sites
};

}  // namespace ccdt

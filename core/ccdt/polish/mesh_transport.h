// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>

#include "core/ccdt/polish/excess_flow.h"
#include "core/ccdt/polish/first_row.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Removes long waves of density error in domains of any shape, as Transport does in boxes and on tori. Computes the
/// smoothed difference between actual and wanted density, and small moves of all sites that cancel this difference.
///
/// The excess of sites is measured on a grid. The excess flows along the edges of the triangulation, which have the
/// conductances of linear finite elements. So nothing flows across the border or between parts of the domain. Therefore
/// the wanted density of each part is scaled such that the part wants as many sites as it has. The density must vary
/// little between neighbouring sites.
///
/// Source: as for Transport, but Laplace's equation is solved on the mesh; README.md has the derivation.
class MeshTransport {
public:
    /// @param mesh     trimmed, not of a torus
    /// @param density  wanted density of sites
    ///
    /// O(sites + vertices of the border + cells of the grid). The grid has at most 64 cells per site.
    MeshTransport(const Domain& domain, const Density& density, const Triangulation& mesh);

    /// Function that computes the share of the error, in sites, that is assigned to each site, as ErrorGrid::at() does.
    using Measure = std::function<void(std::span<const Point> sites, std::span<double> errors)>;

    /// Function that returns whether the excess may flow along the edge between two sites.
    using Passes = std::function<bool(std::uint32_t, std::uint32_t)>;

    /// Computes the errors of the sites by `measure`. Only edges that `passes` accepts carry a flow. O(sites + vertices
    /// of the border).
    MeshTransport(const Triangulation& mesh, Measure measure, const Passes& passes);

    /// Computes the moves of one round. Sites keep at least half a row of distance from the border. Sites that are
    /// already nearer come no nearer.
    /// @param mesh      the mesh given at construction; edges may have been flipped, and sites moved by up to two
    ///                  spacings
    /// @param spacings  [sites] 1 / sqrt(wanted density of sites)
    /// @param moves     out [sites], each at most 0.35 of the local spacing
    /// @param stop      polled regularly
    /// @returns         false after a stop; the moves must not be used then
    ///
    /// O(sites + vertices of the border).
    bool displacements(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves,
                       const std::stop_token& stop = {});
    /// Computes the moves of one round as the overload without `row` does.
    /// @param row  first row of the current mesh
    bool displacements(const Triangulation& mesh, const FirstRow& row, std::span<const double> spacings,
                       std::span<Point> moves, const std::stop_token& stop = {});

private:
    ExcessFlow flow_;
    Measure measure_;
};

}  // namespace ccdt

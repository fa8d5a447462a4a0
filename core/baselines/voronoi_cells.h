// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/baselines/bisection.h"
#include "core/baselines/periodic_images.h"
#include "core/baselines/polygon_moments.h"

namespace ccdt {

/// Integrates the square of a density over the Voronoi cells of sites, clipped to a domain.
///
/// Triangles of the domain are bisected until few sites can be nearest to any point in them, and are then clipped at
/// the bisectors between these sites. A triangle of negligible mass is not divided further, but assigned to the site
/// nearest to its centre. Otherwise triangles far from all sites would be divided very often, because many sites are
/// almost equally near to them.
class VoronoiCells {
public:
    /// @param mesh     mesh of the domain: the initial triangles, unless the domain is a box
    /// @param density  must outlive this
    VoronoiCells(const Domain& domain, const Triangulation& mesh, const Density& density);

    /// Integrates over the cells of all sites.
    /// @param sites  [n >= 1] distinct; on a torus, any periodic copy
    /// @param stop   polled regularly
    /// @returns      [n] with first moments relative to the site; incomplete after a stop
    ///
    /// Exact except for rounding and triangles of negligible mass. O(n log n + cells of the density crossed by edges).
    std::vector<Moments> integrate(std::span<const Point> sites, const std::stop_token& stop) const;

private:
    class Integration;

    PeriodicImages images_;
    Bisection bisection_;
    SquaredDensity weight_;
    std::vector<Part> parts_;
    double total_ = 0;  ///< mass of the domain
};

}  // namespace ccdt

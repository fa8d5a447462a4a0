#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/baselines/bisection.h"
#include "core/baselines/periodic_images.h"
#include "core/baselines/polygon_moments.h"

namespace ccdt {

/// Integrates the square of a density over the parts of a domain that are nearer to one site than to any other.
///
/// Triangles of the domain are bisected until few sites are left that may be nearest to some place in them, and then
/// clipped at the bisectors between those. A triangle of next to no mass goes undivided to the site nearest to its
/// centre, since seen from far off many sites are almost equally near.
class VoronoiCells {
public:
    /// @param mesh     of the domain: the triangles to begin with, unless the domain is a box
    /// @param density  must outlive this
    VoronoiCells(const Domain& domain, const Triangulation& mesh, const Density& density);

    /// @param sites  [n >= 1] distinct; on a torus anywhere
    /// @param stop   asked now and then
    /// @returns      [n] first moments are seen from the site; unfinished if stopped
    /// Exact but for rounding and those triangles. O(n log n), and cells of the density that edges cross.
    std::vector<Moments> integrate(std::span<const Point> sites, const std::stop_token& stop) const;

private:
    class Integration;

    PeriodicImages images_;
    Bisection bisection_;
    SquaredDensity weight_;
    std::vector<Part> parts_;
    double total_ = 0;  ///< mass
};

}  // namespace ccdt

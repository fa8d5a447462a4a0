// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/cvt.h"

#include <vector>

#include "core/baselines/site_mesh.h"
#include "core/baselines/voronoi_cells.h"

namespace ccdt {

namespace {

/// Moves all sites to the centroids of their cells.
/// @returns  false if no site moves
bool move_to_centroids(SiteMesh& sites, const VoronoiCells& voronoi, const std::stop_token& stop) {
    constexpr double kRest = 1e-12;      // in the unit frame; smaller moves are rounding errors
    constexpr double kCancelled = 1e-9;  // smaller masses, relative to the magnitude, may be rounding errors
    const auto cells = voronoi.integrate(sites.sites(), stop);
    if (stop.stop_requested()) return false;
    std::vector<Point> wanted(sites.sites().begin(), sites.sites().end());
    bool moves = false;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (!(cells[i].mass > kCancelled * cells[i].magnitude)) continue;
        const Point by = 1 / cells[i].mass * cells[i].first;
        moves = moves || dot(by, by) > kRest * kRest;
        wanted[i] = wanted[i] + by;
    }
    return moves && sites.move(wanted);
}

}  // namespace

Result<Distribution> cvt(const Domain& domain, const Density& density, const Options& options, const Control& control) {
    auto sites = SiteMesh::create(domain, density, options, control.stop);
    if (!sites) return tl::unexpected(sites.error());
    const VoronoiCells voronoi(domain, sites->mesh(), density);
    return sites->iterate(options, control, [&] { return move_to_centroids(*sites, voronoi, control.stop); });
}

}  // namespace ccdt

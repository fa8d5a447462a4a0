// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/plane/ccdt.h"

namespace ccdt {

/// Number of iterations after which Lloyd's method hardly moves sites.
inline constexpr int kCvtIterations = 100;

/// Distributes sites by Lloyd's method, which converges to a centroidal Voronoi tessellation: each site is the centroid
/// of its cell, which consists of the points nearer to this site than to any other.
///
/// Cells are clipped to the domain. Their integrals are exact (voronoi_cells.h). If a centroid lies outside the domain,
/// the site moves only part of the way.
///
/// @param options  passes and quality are ignored; `iterations` is the largest number of moves of all sites; the method
///                 ends earlier if no site moves
/// @returns        as distribute(): the trace holds the capacity variation of the sites' Delaunay triangulation, which
///                 the method does not minimise
///
/// Errors: those of distribute(). Deterministic. O(n log n) per iteration.
/// Source: Lloyd 1982; Du, Faber, Gunzburger 1999, section 5.2. Departure: centroids are weighted by the square of the
/// density. Cells of a centroidal tessellation tend to have equal energies, not equal masses (ibid., section 6.4.1). So
/// in the plane, the density of sites is the square root of the weight. With the squared density as weight, the density
/// of sites is the wanted density.
Result<Distribution> cvt(const Domain& domain, const Density& density, const Options& options,
                         const Control& control = {});

}  // namespace ccdt

#pragma once

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Iterations after which Lloyd's method hardly moves sites any more.
inline constexpr int kCvtIterations = 100;

/// Distributes sites by Lloyd's method: towards a centroidal Voronoi tessellation, in which every site is the centroid
/// of its cell, the places nearer to it than to any other site.
///
/// In a domain a cell is what of it lies there. Its integrals are exact (voronoi_cells.h). A centroid outside the
/// domain is approached only.
///
/// @param options  passes and quality do not matter. `iterations` moves of all sites, fewer where they come to rest
/// @returns        as distribute(): the trace holds the capacity variation of the sites' Delaunay triangulation, which
///                 the method does not minimise
/// Errors: those of distribute(). Same input, same bytes. O(n log n) per iteration.
/// Source: Lloyd 1982; Du, Faber, Gunzburger 1999, section 5.2. Departure: centroids are weighted by the square of the
/// density. Cells of a centroidal tessellation come to equal energies, not masses (ibid., section 6.4.1), so that in
/// the plane sites are as dense as the square root of the weight: thus as dense as the density wants.
Result<Distribution> cvt(const Domain& domain, const Density& density, const Options& options,
                         const Control& control = {});

}  // namespace ccdt

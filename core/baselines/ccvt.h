#pragma once

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Most iterations. The method ends by itself, mostly after a tenth of them.
inline constexpr int kCcvtIterations = 1000;

/// Distributes sites by a capacity-constrained Voronoi tessellation: each site is the centroid of a cell, and all cells
/// hold exactly the same number of samples of the density.
///
/// 256 samples a site, up to 1,024 where there are fewer than 1,024 sites, random and stratified (mass_samples.h), are
/// dealt out and swapped (equal_cells.h). A centroid outside the domain is approached only.
///
/// @param options  passes do not matter. `iterations` sweeps over all pairs of sites; fewer where no swap is left
/// @returns        as distribute(): the trace holds the capacity variation of the sites' Delaunay triangulation; that
///                 of the method's own cells is 0 always
/// Errors: those of distribute(). Same input, same bytes. O(samples) per iteration.
/// Source: Balzer, Schloemer, Deussen 2009; Li, Nehab, Wei, Sander, Fu 2010.
Result<Distribution> ccvt(const Domain& domain, const Density& density, const Options& options,
                          const Control& control = {});

}  // namespace ccdt

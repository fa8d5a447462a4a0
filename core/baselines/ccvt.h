// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/plane/ccdt.h"

namespace ccdt {

/// Largest number of iterations. The method mostly ends after a tenth of this number.
inline constexpr int kCcvtIterations = 1000;

/// Distributes sites by a capacity-constrained Voronoi tessellation: each site is the centroid of a cell, and all cells
/// have exactly the same number of samples of the density.
///
/// Each site gets 256 stratified random samples (mass_samples.h). If there are fewer than 1,024 sites, each gets more,
/// up to 1,024 samples. Cells then swap samples (equal_cells.h). If a centroid lies outside the domain, the site moves
/// only part of the way.
///
/// @param options  passes are ignored; `iterations` is the largest number of sweeps over all pairs of sites; the method
///                 ends earlier if no swap lowers the energy
/// @returns        as distribute(): the trace holds the capacity variation of the sites' Delaunay triangulation; the
///                 capacity variation of the method's own cells is always 0
///
/// Errors: those of distribute(). Deterministic. O(samples) per iteration.
/// Source: Balzer, Schloemer, Deussen 2009; Li, Nehab, Wei, Sander, Fu 2010.
Result<Distribution> ccvt(const Domain& domain, const Density& density, const Options& options,
                          const Control& control = {});

}  // namespace ccdt

#pragma once

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Distributes sites independently of each other, by the density: white noise.
///
/// @param options  iterations, passes, tolerance and start do not matter
/// @returns        as distribute(): the capacity variation of the sites' Delaunay triangulation is the only entry of
///                 the trace
/// Errors: those of distribute(). Same input, same bytes. O(sites log sites).
Result<Distribution> random_sites(const Domain& domain, const Density& density, const Options& options,
                                  const Control& control = {});

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/plane/ccdt.h"

namespace ccdt {

/// Distributes sites independently of each other with the given density: white noise.
///
/// @param options  iterations, passes, tolerance and start are ignored
/// @returns        as distribute(): the only entry of the trace is the capacity variation of the sites' Delaunay
///                 triangulation
///
/// Errors: those of distribute(). Deterministic. O(sites log sites).
Result<Distribution> random_sites(const Domain& domain, const Density& density, const Options& options,
                                  const Control& control = {});

}  // namespace ccdt

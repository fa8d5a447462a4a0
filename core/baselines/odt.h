// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/ccdt/plane/ccdt.h"

namespace ccdt {

/// Number of iterations after which the method hardly moves sites.
inline constexpr int kOdtIterations = 100;

/// Distributes sites by optimal Delaunay triangulation: minimises the error of the piecewise linear interpolation of
/// the squared distance from a point.
///
/// Each site in turn moves to the mean of the circumcentres of the triangles around it, weighted by the areas of the
/// triangles. As long as the triangles stay the same, this position minimises the error. Then the triangulation is made
/// Delaunay again. A move that would make a triangle too small or too thin is halved until it fits. Border vertices do
/// not move.
///
/// @param options  passes are ignored
/// @returns        as distribute(): the trace holds the capacity variation of the triangulation, which the method does
///                 not minimise
///
/// Errors: those of distribute(). Deterministic. O(sites) per iteration.
/// Source: Chen and Xu 2004, section 4; Alliez, Cohen-Steiner, Yvinec, Desbrun 2005, equation 5. Departures: areas are
/// weighted by the density to the power of 3/2. Where triangle sizes vary, sites are in equilibrium if the weight is
/// inversely proportional to the third power of the edge length. Triangles that touch the border have a larger weight.
/// So the first row of sites lies half a row from the border. With equal weights it would lie a whole row away, because
/// the vertices on the border would act like sites.
Result<Distribution> odt(const Domain& domain, const Density& density, const Options& options,
                         const Control& control = {});

}  // namespace ccdt

#pragma once

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Iterations after which the method hardly moves sites any more.
inline constexpr int kOdtIterations = 100;

/// Distributes sites towards an optimal Delaunay triangulation, whose piecewise linear interpolation of the squared
/// distance from a point errs least.
///
/// Each site in turn moves to the mean of the circumcentres of the triangles around it, weighted by their areas, which
/// minimises that error as long as the triangles stay the same; then the triangulation is made Delaunay again. A move
/// that would turn a triangle over is halved until it does not. Vertices along the border stay where they are.
///
/// @param options  passes do not matter
/// @returns        as distribute(): the trace holds the capacity variation of the triangulation, which the method does
///                 not minimise
/// Errors: those of distribute(). Same input, same bytes. O(sites) per iteration.
/// Source: Chen and Xu 2004, section 4; Alliez, Cohen-Steiner, Yvinec, Desbrun 2005, equation 5. Departures: areas are
/// weighted by the density to the power of 3/2: where the sizes of the triangles change from one to the next,
/// circumcentres balance if the weight falls as the third power of the size. Triangles that touch the border weigh
/// more, so that the first row of sites lies half a row away from it, and not a whole one as if the border's vertices
/// were sites.
Result<Distribution> odt(const Domain& domain, const Density& density, const Options& options,
                         const Control& control = {});

}  // namespace ccdt

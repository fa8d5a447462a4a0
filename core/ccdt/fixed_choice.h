#pragma once

#include <span>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"
#include "core/polish/fixed_sites.h"

namespace ccdt {

/// Chooses those fixed points that get a vertex: inside, and not so close to the border or to each other that what lies
/// between is a needle. The others are thinned, but for ones so close that they make no difference.
///
/// @param points   in the unit frame, in an order in which neighbours are near
/// @param weights  [points] room that each takes; what is too close to another adds to its
/// @param spacing  of sites where they are densest
/// @param trial    of the border alone, with room for all points; used up
/// @returns        but for the number of sites
FixedSites choose_fixed(const Domain& domain, std::span<const Point> points, std::span<const double> weights,
                        double spacing, Triangulation& trial);

}  // namespace ccdt

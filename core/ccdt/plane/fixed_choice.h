// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "core/ccdt/polish/fixed_sites.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Chooses the fixed points that become vertices. These points lie inside the domain, and not so close to the border or
/// to each other that needles arise. The other points are kept as obstacles (FixedSites::others), unless they nearly
/// coincide with another obstacle.
///
/// @param points   in the unit frame, in an order that keeps neighbours close
/// @param weights  [points] area that each point takes (FixedArea::weights); the weight of a point too close to a
///                 vertex is added to this vertex
/// @param spacing  least spacing of sites
/// @param trial    triangulation of the border alone, to which all points can be added; modified by trial insertions
/// @returns        the chosen points; the member `sites` is not set
FixedSites choose_fixed(const Domain& domain, std::span<const Point> points, std::span<const double> weights,
                        double spacing, Triangulation& trial);

}  // namespace ccdt

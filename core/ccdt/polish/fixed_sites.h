// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Existing points of a domain, in the unit frame. No step moves them, and free sites keep a distance from them.
struct FixedSites {
    double sites = 0;              ///< area of the domain, in units of the area that each free site gets
    std::vector<Point> positions;  ///< points that have a vertex; they are the last sites of the mesh
    std::vector<double> weights;   ///< [positions] area that each point takes, in the units of `sites`
    /// Points without a vertex: outside the domain, or too close to the border or to a point with a vertex.
    std::vector<Point> others;
};

}  // namespace ccdt

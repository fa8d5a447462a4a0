#pragma once

#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Points of a domain, in the unit frame, that are there already: sites keep clear of them, and they stay.
struct FixedSites {
    double sites = 0;             ///< room in the domain, in units of what each free site has of it
    std::vector<Point> places;    ///< of those that are the last sites of the mesh
    std::vector<double> weights;  ///< [places] room that they take, in the same units
    std::vector<Point> others;    ///< that have no vertex: outside, or too close to the border or to one that has
};

}  // namespace ccdt

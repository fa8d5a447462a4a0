#pragma once

#include "core/geometry/polygon.h"

namespace ccdt {

/// Removes corners of a ring that are within a distance of the edges that replace theirs. A ring that would have fewer
/// than three corners stays as it is. The result may cross itself. O(n).
/// Source: Douglas and Peucker, Algorithms for the reduction of the number of points, Cartographica 10 (1973).
/// Departure: chains of 256 corners are reduced on their own, which bounds time and depth.
Ring simplified(const Ring& ring, double distance);

}  // namespace ccdt

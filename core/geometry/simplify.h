// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/geometry/polygon.h"

namespace ccdt {

/// Simplifies a ring: removes corners that lie within `distance` of the edges that replace them. A ring that would have
/// fewer than three corners is returned unchanged. The result may cross itself. O(n).
///
/// Source: Douglas and Peucker, Algorithms for the reduction of the number of points, Cartographica 10 (1973).
/// Departure: chains of 256 corners are simplified independently, which bounds time and recursion depth.
Ring simplified(const Ring& ring, double distance);

}  // namespace ccdt

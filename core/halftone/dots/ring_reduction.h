// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Replaces the corners of a ring with fewer corners that enclose exactly the same area.
///
/// Corners on the sides of the box do not move. The result is empty if the area of the ring is below a hundredth of the
/// displacement.
/// @param ring          closed, without repetition of the first point
/// @param displacement  largest area between the ring and its replacement that one step may add; at most a tenth of the
///                      area of the ring is used
/// O(n log n).
/// Source: Kronenfeld, Stanislawski, Buttenfield, Brockmeyer 2020, Simplification of polylines by segment collapse:
/// minimizing areal displacement while preserving area.
std::vector<Point> reduced_ring(const std::vector<Point>& ring, double displacement, const Box& box);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// Rounds the quotas of places to whole numbers so that errors cancel among near places.
///
/// @param positions  [n] finite; all in one plane, or near one surface
/// @param quotas     [classes][n] finite, >= 0, with sums below 2^53
/// @returns          [classes][n] each number is its quota rounded up or down, and the numbers of a class add up to the
///                   rounded sum of its quotas
///
/// A binary tree divides the places in halves, across the longer side of their bounding box. In every node, the sum of
/// the numbers of a class is the sum of its quotas rounded up or down. The sum over all classes differs by less than
/// one from the sum of their quotas, too, unless the rounding of the classes themselves prevents this. Then single
/// units are moved between near places, as long as this keeps the sums of the nodes and reduces an energy: the sum over
/// pairs of places of the product of their errors and a kernel of their distance. So units are spread evenly where
/// quotas are below one.
///
/// The result depends on the positions of the places, not on their order, except for places at the same position.
/// Deterministic. O(n log n).
std::vector<std::vector<std::size_t>> apportion(std::span<const Point3> positions,
                                                std::span<const std::vector<double>> quotas);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Dots of a kind as they are drawn.
struct SizedDots {
    std::vector<float> radii;         ///< [dots], in cells
    std::vector<std::uint8_t> white;  ///< [dots] channels whose ground is white at the centre, as bits
    std::vector<std::uint8_t> cut;    ///< [dots] channels, of those flipped, whose boundary is near, as bits
};

/// Chooses the radii of dots such that the local mean of what is drawn is that of the picture in each channel, also
/// where the boundary of the ground cuts dots: where it does, the part of a dot beyond the boundary has the opposite
/// colour.
///
/// @param sites  [kinds] in cells, y down the rows
/// @param fit    false: each dot has the area that is planned where it lies
/// @returns      [kinds]
/// Same input, same bytes, on any executor. O(cells + sites).
std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt

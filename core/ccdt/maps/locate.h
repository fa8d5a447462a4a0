// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the area in which each of several points lies. Where areas overlap, the result is the first of them. If a
/// point lies in no area, or on a border that two areas share, the result is the area whose border is nearest.
///
/// @param areas   [n >= 1], none of them a torus
/// @param period  distance along x after which positions repeat, such as 360 degrees of longitude; 0: positions do not
///                repeat
/// @returns       indices of areas [points]
/// Errors: Stopped. O(edges in the row of the point) for each point.
Result<std::vector<std::uint32_t>> locate(std::span<const Domain* const> areas, std::span<const Point> points,
                                          double period = 0, const std::stop_token& stop = {});

}  // namespace ccdt

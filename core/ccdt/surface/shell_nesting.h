// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// A triangle of a closed shell.
struct ShellFace {
    std::array<std::uint32_t, 3> corners;  ///< indices of positions
    std::uint32_t shell;
};

/// Determines which closed shells contain a point of each shell, by the parity of the crossings of a ray.
/// @param positions  in [0, 1]
/// @param points     [shells] a point on each shell
///
/// Returns the shells around each one, in increasing order [shells]; nothing if shells are so large and so many that
/// this takes more than 50 tests per face. Deterministic. O(faces + crossings), typically.
std::vector<std::vector<std::uint32_t>> shells_around(std::span<const Point3> positions,
                                                      std::span<const ShellFace> faces, std::span<const Point3> points);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt::choice {

/// Chooses candidates that are at least `spacing` apart, as choose_apart() describes.
/// @param positions   [n >= 1] in a box from the origin, whose longest side is 1
/// @param torus       sides of a torus; 0 if the box is not a torus
/// @param is_solid    whether candidates fill a volume
/// @param priorities  [n] or empty
/// @param kept        [n] 1 for candidates that are always chosen
/// @param spacing     at least 1e-150 is used, so coincident candidates are always too near
/// @returns           indices in the order of the choice
std::vector<std::uint32_t> pack(std::span<const Point3> positions, Point3 torus, bool is_solid,
                                std::span<const double> priorities, std::span<const std::uint8_t> kept, double spacing,
                                const std::stop_token& stop);

}  // namespace ccdt::choice

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>

namespace ccdt {

inline constexpr double kTurn = 360;                       ///< one turn around the globe, in degrees of longitude
inline constexpr double kDegree = std::numbers::pi / 180;  ///< one degree, in radians

/// Returns the multiple of 360 degrees that shifts a longitude to its first equivalent at or east of `least`.
inline double longitude_wrap_offset(double longitude, double least) {
    return kTurn * std::ceil((least - longitude) / kTurn);
}

}  // namespace ccdt

#pragma once

#include <cmath>
#include <numbers>

namespace ccdt {

inline constexpr double kTurn = 360;                       ///< degrees of longitude around the globe
inline constexpr double kDegree = std::numbers::pi / 180;  ///< radians

/// Turns, in degrees, that bring a longitude to the first place at or east of another one where it is the same
/// meridian.
inline double shift_to(double longitude, double least) {
    return kTurn * std::ceil((least - longitude) / kTurn);
}

}  // namespace ccdt

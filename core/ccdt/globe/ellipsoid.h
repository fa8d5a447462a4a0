// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt {

// The ellipsoid WGS 84.
inline constexpr double kEquatorialRadius = 6'378'137;  ///< metres
inline constexpr double kFlattening = 1 / 298.257223563;
inline constexpr double kSquaredEccentricity = kFlattening * (2 - kFlattening);

}  // namespace ccdt

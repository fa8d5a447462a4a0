// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace ccdt {

/// Returns the slope of CIE 1976 lightness at a luminance. Lightness and luminance are in [0, 1].
inline float lightness_slope(float luminance) {
    constexpr float kLinearBelow = 216.0f / 24389.0f, kSlope = 24389.0f / 2700.0f;
    if (luminance <= kLinearBelow) return kSlope;
    const float root = std::cbrt(luminance);
    return 1.16f / 3 / (root * root);
}

}  // namespace ccdt

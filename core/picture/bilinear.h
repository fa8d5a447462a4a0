// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Position between two neighbouring pixel centres along one axis, limited to the range of the outermost centres.
struct BetweenPixels {
    /// @param position  in pixels; the first pixel covers [0, 1]
    /// @param pixels    >= 1
    BetweenPixels(double position, int pixels) {
        const double inside = std::clamp(position - 0.5, 0.0, pixels - 1.0);
        const int before = std::min(static_cast<int>(inside), std::max(pixels - 2, 0));
        first = static_cast<std::size_t>(before);
        second = static_cast<std::size_t>(std::min(before + 1, pixels - 1));
        share = static_cast<float>(inside - before);
    }

    std::size_t first, second;
    float share;  ///< weight of `second`, in [0, 1]
};

/// Interpolates linearly from a to b.
inline float mix(float a, float b, float share) {
    return a + share * (b - a);
}

/// Interpolates an image bilinearly between its pixel centres.
///
/// @param values    [width * height]
/// @param position  in pixels from the image's upper left corner
inline float interpolated(const std::vector<float>& values, int width, int height, Point position) {
    const BetweenPixels x(position.x, width), y(position.y, height);
    const float* upper = values.data() + y.first * static_cast<std::size_t>(width);
    const float* lower = values.data() + y.second * static_cast<std::size_t>(width);
    return mix(mix(upper[x.first], upper[x.second], x.share), mix(lower[x.first], lower[x.second], x.share), y.share);
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/visibility.h"

#include <cmath>

#include "core/halftone/colour_difference.h"

namespace ccdt {

namespace {

/// Returns the slope of CIE 1976 lightness at a luminance. Lightness and luminance are in [0, 1].
float lightness_slope(float luminance) {
    constexpr float kLinearBelow = 216.0f / 24389.0f, kSlope = 24389.0f / 2700.0f;
    if (luminance <= kLinearBelow) return kSlope;
    const float root = std::cbrt(luminance);
    return 1.16f / 3 / (root * root);
}

}  // namespace

Visibility::Visibility(std::span<const float> light) : channels_(light.size()) {
    if (channels_ == 1) {
        slopes_[0][0] = lightness_slope(light[0]);
        return;
    }
    constexpr float kColour = 0.5f;
    std::array<float, 3> slope{}, level{};
    for (std::size_t k = 0; k < 3; ++k) {
        float value = 0;
        for (std::size_t c = 0; c < 3; ++c) value += static_cast<float>(kLightToXyz[k][c]) * light[c];
        slope[k] = lightness_slope(value);
        // Lightness is slope * value on the linear part, and 1.16 root - 0.16 above, where root = cbrt(value). There,
        // slope = 1.16 / 3 / root^2, so 1.16 root = 3 * value * slope.
        level[k] = value * slope[k] < 0.08f ? value * slope[k] : 3 * value * slope[k] - 0.16f;
    }
    const float chroma = 100 * std::hypot(500.0f / 116 * (level[0] - level[1]), 200.0f / 116 * (level[1] - level[2]));
    const float weight = kColour / (1 + 0.045f * chroma);
    for (std::size_t c = 0; c < 3; ++c) {
        const auto part = [&](std::size_t k) { return slope[k] * static_cast<float>(kLightToXyz[k][c]); };
        slopes_[c] = {part(1), weight * 500 / 116 * (part(0) - part(1)), weight * 200 / 116 * (part(1) - part(2))};
    }
}

float Visibility::of(unsigned flips, unsigned white) const {
    const auto change = [&](std::size_t c) {
        if ((flips >> c & 1) == 0) return 0.0f;
        return (white >> c & 1) != 0 ? -1.0f : 1.0f;
    };
    if (channels_ == 1) return std::abs(change(0)) * slopes_[0][0];
    const float red = change(0), green = change(1), blue = change(2);
    float sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const float part = red * slopes_[0][k] + green * slopes_[1][k] + blue * slopes_[2][k];
        sum += part * part;
    }
    return std::sqrt(sum);
}

float Visibility::of(const std::array<float, 3>& change) const {
    if (channels_ == 1) return std::abs(change[0]) * slopes_[0][0];
    std::array<float, 3> sum{};
    for (std::size_t c = 0; c < channels_; ++c) {
        for (std::size_t k = 0; k < 3; ++k) sum[k] += change[c] * slopes_[c][k];
    }
    return std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace ccdt {

/// Returns the slope of CIE 1976 lightness at a luminance. Lightness and luminance are in [0, 1].
inline float lightness_slope(float luminance) {
    constexpr float kLinearBelow = 216.0f / 24389.0f, kSlope = 24389.0f / 2700.0f;
    if (luminance <= kLinearBelow) return kSlope;
    const float root = std::cbrt(luminance);
    return 1.16f / 3 / (root * root);
}

/// Visibility of small changes of light, at a given colour.
///
/// With one channel, the visibility is the derivative of CIE 1976 lightness. With three channels, it is the derivative
/// of the difference in CIELAB. Differences in a* and b* have half the weight of chroma in CIE 1994.
class Visibility {
public:
    /// @param light  [1 or 3] linear light of each channel, in [0, 1]
    explicit Visibility(std::span<const float> light);

    /// Returns the visible difference per flipped share of the area, in units in which black and white differ by 1.
    ///
    /// @param flips  channels that are flipped, as bits
    /// @param white  channels that lose their light when flipped, as bits; the other channels gain it
    float of(unsigned flips, unsigned white) const;

    /// Returns the visible difference per changed share of the area, in units in which black and white differ by 1.
    /// @param change  change of each channel within the changed area
    float of(const std::array<float, 3>& change) const;

private:
    std::size_t channels_;
    /// [channels] derivatives of lightness and of the two weighted colour axes with respect to the channel's light.
    std::array<std::array<float, 3>, 3> slopes_{};
};

}  // namespace ccdt

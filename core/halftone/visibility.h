// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace ccdt {

/// Visibility of small changes in the channels of a colour.
///
/// For one channel, the slope of CIE 1976 lightness. For three, the slope of the difference in CIELAB, with
/// that of chroma and hue weighted as CIE 1994 does for chroma and by a half.
class Visibility {
public:
    /// @param light  of 1 or 3 channels, linear, in [0, 1]
    explicit Visibility(std::span<const float> light);

    /// Computes the difference over the share, where a share of the area is flipped.
    ///
    /// @param flips  channels that are flipped, as bits
    /// @param white  channels of which flipping takes the light, as bits; of others it brings it
    /// @returns      difference in lightnesses from 0 to 1
    float of(unsigned flips, unsigned white) const;

    /// Computes the difference over the share, where a share of the area changes its light.
    /// @param change  of each channel, in full
    float of(const std::array<float, 3>& change) const;

private:
    std::size_t channels_;
    std::array<std::array<float, 3>, 3> slopes_{};  ///< by channel: of lightness, and of both colour axes
};

}  // namespace ccdt

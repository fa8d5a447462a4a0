// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace ccdt {

/// Visibility of small changes in the channels of a colour.
///
/// With one channel, the visibility is the slope of CIE 1976 lightness. With three channels, it is the slope of the
/// difference in CIELAB. Differences in a* and b* have half the weight that CIE 1994 gives to differences in chroma.
class Visibility {
public:
    /// @param light  [1 or 3] linear light of each channel, in [0, 1]
    explicit Visibility(std::span<const float> light);

    /// Returns the visible difference per share of the area that is flipped, in units in which black and white differ
    /// by 1.
    ///
    /// @param flips  channels that are flipped, as bits
    /// @param white  channels that lose their light when flipped, as bits; the other channels gain it
    float of(unsigned flips, unsigned white) const;

    /// Returns the visible difference per share of the area that changes, in units in which black and white differ by
    /// 1.
    /// @param change  change of each channel within the changed area
    float of(const std::array<float, 3>& change) const;

private:
    std::size_t channels_;
    /// [channels] derivatives of lightness and of the two weighted colour axes with respect to the channel's light.
    std::array<std::array<float, 3>, 3> slopes_{};
};

}  // namespace ccdt

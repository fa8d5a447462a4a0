// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/halftone/ground.h"
#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"

namespace ccdt {

/// Returns the number of possible kinds of dots: the number of non-empty sets of channels.
constexpr std::size_t kinds_of(std::size_t channels) {
    return (std::size_t{1} << channels) - 1;
}

/// Returns the channels that dots of a kind flip, as bits.
constexpr unsigned flips_of(std::size_t kind) {
    return static_cast<unsigned>(kind) + 1;
}

/// Largest number of kinds that a plan for inks uses.
inline constexpr std::size_t kMaxInkKinds = 15;

/// A channel of a picture, divided into grounds.
struct TwoSidedChannel {
    Ground ground;
    std::vector<float> light;  ///< [cells] light of the picture; for an ink, the share left bare
    std::vector<float> white;  ///< [cells] share of white ground
};

/// Dots that flip the same channels.
struct KindOfDots {
    unsigned flips = 0;          ///< channels, as bits
    std::vector<float> density;  ///< [cells] dots per area, up to a factor; 0 everywhere if the kind has no dots
    std::vector<float> area;     ///< [cells] area of a dot at this position, in cells
    double share = 0;            ///< sum of `density` over all cells; the number of dots, up to a factor
};

/// Plan of a halftone with ink dots on white ground and paper dots on black ground.
///
/// White ground has the light 1 in a channel, black ground 0. Where the picture has the light Y, ink dots cover the
/// share 1 - Y of white ground, or paper dots cover the share Y of black ground. Both shares are at most about one
/// half. So dots hardly ever overlap, and the covered share is the number of dots per area times the area of a dot.
///
/// In red, green and blue, the flipped areas of the channels are nested. A place has up to three kinds of dots. The
/// first flips all three channels. The second flips the two channels with the larger flipped areas. The third flips the
/// channel with the largest flipped area. So all dots together cover only the largest area, without overlap.
struct TwoSidedPlan {
    CellGrid cells;
    std::vector<TwoSidedChannel> channels;  ///< grey; or red, green and blue; or one for each ink
    std::vector<KindOfDots> kinds;          ///< sorted by `flips`
    double dots = 0;                        ///< number of dots needed at the areas in `kinds`; 0 if the ground suffices
    double radius = 0;                      ///< radius of the largest dots, in cells
    bool is_nested = true;  ///< whether flipped areas of channels are nested; false: kinds mix in any shares
    /// [2^channels] light of each set of inks; empty if fit_light() is not used.
    std::vector<std::array<float, 3>> colours;
    LightPlanes wanted;  ///< [cells] light of the picture; empty if fit_light() is not used
};

/// Returns the channels whose ground is black in the larger part of a cell, as bits.
inline unsigned black_channels(const TwoSidedPlan& plan, std::size_t cell) {
    unsigned bits = 0;
    for (std::size_t c = 0; c < plan.channels.size(); ++c)
        bits |= static_cast<unsigned>(!(plan.channels[c].white[cell] > 0.5f)) << c;
    return bits;
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/halftone/ground.h"
#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"

namespace ccdt {

/// Number of kinds that dots of so many channels may have: each set of channels but the empty one.
constexpr std::size_t kinds_of(std::size_t channels) {
    return (std::size_t{1} << channels) - 1;
}

/// Channels that dots of a kind flip, as bits.
constexpr unsigned flips_of(std::size_t kind) {
    return static_cast<unsigned>(kind) + 1;
}

/// Number of kinds that dots of several inks have at most.
inline constexpr std::size_t kMostKindsOfInks = 15;

/// Channel of a picture, divided into grounds.
struct TwoSidedChannel {
    Ground ground;
    std::vector<float> light;  ///< [cells] the picture
    std::vector<float> white;  ///< [cells] share of white ground
};

/// Dots that flip the same channels.
struct KindOfDots {
    unsigned flips = 0;          ///< channels, as bits
    std::vector<float> density;  ///< [cells] relative density of the sites; zero everywhere if there are none
    std::vector<float> area;     ///< [cells] area of a dot there, in cells
    double share = 0;            ///< sum of the densities
};

/// Plan of a halftone that draws the minority: ink dots on white ground, paper dots on black ground.
///
/// A grey picture has one channel, its light Y; a picture in colour has three. The ground of each channel is white,
/// where there is all of its light, or black, where there is none. Ink dots cover 1 - Y of white ground, paper dots
/// cover Y of black ground. Both are at most about one half: dots hardly ever overlap, and their number times their
/// area is the tone.
///
/// The areas that are flipped in several channels are nested: a place has dots that flip all channels, dots that flip
/// all but the one that needs least, and dots that flip the one that needs most. So the dots of all kinds together
/// cover no more than the channel that needs most, and lie apart.
struct TwoSidedPlan {
    CellGrid cells;
    std::vector<TwoSidedChannel> channels;  ///< 1 or 3: red, green, blue; or one for each ink
    std::vector<KindOfDots> kinds;          ///< by what they flip
    double dots = 0;        ///< number of dots of these areas that give the picture its tone; 0: the ground says all
    double radius = 0;      ///< of the largest dots, in cells
    bool is_nested = true;  ///< the areas that channels flip are nested; else kinds lie side by side in any mixture
    std::vector<std::array<float, 3>> colours;  ///< [2^channels] light of each set of inks, if light is fitted
    LightPlanes wanted;                         ///< [cells] light of the picture, if it is fitted
};

/// Returns the channels whose ground is black in the larger part of a cell, as bits.
inline unsigned black_channels(const TwoSidedPlan& plan, std::size_t cell) {
    unsigned bits = 0;
    for (std::size_t c = 0; c < plan.channels.size(); ++c)
        bits |= static_cast<unsigned>(!(plan.channels[c].white[cell] > 0.5f)) << c;
    return bits;
}

}  // namespace ccdt

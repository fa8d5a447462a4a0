// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/ground.h"
#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

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

/// Options of a halftone with dots on both sides of the tonal scale.
struct TwoSidedOptions {
    std::optional<std::size_t> sites;  ///< number of dots, >= 1
    std::optional<double> radius;      ///< of the largest dots, in cells, > 0; one of the two at least
    double detail = 0;                 ///< in [0, 1]; how far edges are emphasised
    double least_radius = 0;           ///< radius in cells below which no dot is planned, as far as that is possible
    std::optional<std::size_t> most = std::nullopt;  ///< number of dots beyond which they are larger than `radius`
};

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
};

/// Sums over all cells what dots have to flip: of each cell, the channel of which that is most.
/// @param light  [channels][cells] in [0, 1]
double minority_of(std::span<const std::vector<float>> light, Executor& executor = inline_executor());

/// Divides the picture into grounds and plans the dots.
///
/// Areas follow from what an eye sees. A pattern of one kind that covers the share c by dots of density rho has, after
/// a blur, a contrast of c V exp(-k rho), where V is how far colours are apart in CIELAB per share that is flipped: of
/// grey the slope of lightness. For a given number of dots the sum of that is least where rho is proportional to
/// log(1 + c V / mu). So dots are smaller in shadows, where paper is conspicuous, in highlights, and of rare kinds.
///
/// @param light  [1 or 3][cells] in [0, 1], linear light
/// @param stop   asked between steps; a stop ends it early, with nothing of use
/// Same input, same bytes, on any executor. O(cells).
TwoSidedPlan plan_two_sided(std::vector<std::vector<float>> light, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop = {},
                            Executor& executor = inline_executor());

/// A picture as several inks shall show it.
struct InkPicture {
    std::vector<std::vector<float>> coverage;  ///< [inks][cells] share that each covers, to divide into grounds
    LightPlanes light;                         ///< what shall be seen
};

/// Plans dots of inks, each of which is a channel: black ground is solid ink.
///
/// Light that inks let through is that of all inks on each other, so areas that are flipped need not be nested. Each
/// place has the mixture of its ground and of kinds whose mean colour is nearest to the picture (KindMixture). Of the
/// kinds, the kMostKindsOfInks are used that cover most.
///
/// @param inks  1 to kMostInks, of the tone of the picture's light
TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop = {},
                            Executor& executor = inline_executor());

/// Dots of a kind as they are drawn.
struct SizedDots {
    std::vector<float> radii;         ///< [dots], in cells
    std::vector<std::uint8_t> white;  ///< [dots] channels whose ground is white at the centre, as bits
    std::vector<std::uint8_t> cut;    ///< [dots] channels, of those flipped, whose boundary is near, as bits
};

/// Chooses the radii of dots such that the local mean of what is drawn is that of the picture in each channel, also
/// where the boundary of the ground cuts dots: where it does, the part of a dot beyond the boundary has the opposite
/// colour.
///
/// @param sites  [kinds] in cells, y down the rows
/// @param fit    false: each dot has the area that is planned where it lies
/// @returns      [kinds]
/// Same input, same bytes, on any executor. O(cells + sites).
std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt

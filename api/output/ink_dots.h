// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "api/input/palette.h"
#include "core/ccdt/ccdt.h"
#include "core/geometry/point.h"
#include "core/halftone/dot_fit.h"

namespace ccdt::api {

/// Black ground of each channel of a halftone with dots on both sides of the tonal scale, in the units of the points.
struct Grounds {
    std::span<const Ink> inks;                           ///< [channels]
    std::vector<std::vector<std::vector<Point>>> rings;  ///< [channels] rings around black ground, by the even-odd rule
};

/// Dots that flip the same channels, on both sides of the tonal scale, in the units of the points.
struct TwoSidedDots {
    const SizedDots& dots;  ///< in `white`, a bit is set for each channel whose ground is white
    unsigned flips;         ///< one bit for each channel that the dots flip
    const Grounds& grounds;
};

/// Dots of an ink, as writers receive them. All objects that this one refers to must outlive it.
struct InkDots {
    const Ink& ink;
    const Distribution& dots;
    double radius = 0;                        ///< radius of each dot, in the units of the points; used only by drawings
    const TwoSidedDots* two_sides = nullptr;  ///< null: all dots are ink, of one size
};

/// Calls function(channel) for each channel whose bit is set.
template <class Function>
void for_channels(unsigned bits, const Function& function) {
    for (std::size_t channel = 0; bits >> channel != 0; ++channel) {
        if ((bits >> channel & 1) != 0) function(channel);
    }
}

/// Returns whether answers name inks. A single ink has no name, and answers contain only its points.
inline bool are_named(std::span<const InkDots> inks) {
    return std::ranges::any_of(inks, [](const InkDots& each) { return !each.ink.name.empty(); });
}

/// Returns the ranks of `count` points from `first` on; empty if the points have no ranks.
inline std::span<const std::uint32_t> ranks_of(const Distribution& points, std::size_t first, std::size_t count) {
    const std::span<const std::uint32_t> all = points.ranks;
    return all.empty() ? all : all.subspan(first, count);
}

inline std::size_t count_points(std::span<const InkDots> inks) {
    std::size_t points = 0;
    for (const InkDots& each : inks) points += each.dots.points.size();
    return points;
}

}  // namespace ccdt::api

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
#include "core/halftone/two_sided.h"

namespace ccdt::api {

/// Grounds of a drawing with dots on both sides of the tonal scale, in the points' units.
struct Grounds {
    std::span<const Ink> inks;                           ///< [channels]
    std::vector<std::vector<std::vector<Point>>> rings;  ///< [channels] around ground that is ink, by the even-odd rule
};

/// Dots of one kind on both sides of the tonal scale, in the points' units.
struct TwoSidedDots {
    const SizedDots& dots;  ///< `white` tells of channels whose ground is not ink
    unsigned flips;         ///< channels, as bits
    const Grounds& grounds;
};

/// Dots of an ink, as writers of answers take them; what they refer to must outlive them.
struct InkDots {
    const Ink& ink;
    const Distribution& dots;
    double radius = 0;                        ///< of each dot, in the points' units; only drawings ask for it
    const TwoSidedDots* two_sides = nullptr;  ///< null: all dots are ink, of one size
};

/// Calls function(channel) for each of some channels that are given as bits.
template <class Function>
void for_channels(unsigned bits, const Function& function) {
    for (std::size_t channel = 0; bits >> channel != 0; ++channel) {
        if ((bits >> channel & 1) != 0) function(channel);
    }
}

/// Tells whether answers tell inks apart. Of the only ink, which has no name, they tell nothing but its points.
inline bool are_named(std::span<const InkDots> inks) {
    return std::ranges::any_of(inks, [](const InkDots& each) { return !each.ink.name.empty(); });
}

/// Ranks of some points, or none.
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

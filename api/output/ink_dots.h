// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "api/input/palette.h"
#include "core/ccdt/ccdt.h"
#include "core/geometry/point.h"
#include "core/halftone/dot_fit.h"

namespace ccdt::api {

/// Black ground of each channel of a halftone with dots on both sides of the tonal scale. Coordinates are in the units
/// of the points.
struct Grounds {
    std::span<const Ink> inks;                           ///< [channels]
    std::vector<std::vector<std::vector<Point>>> rings;  ///< [channels] rings around black ground, by the even-odd rule
};

/// Dots that flip the same channels, on both sides of the tonal scale, in the units of the points.
struct TwoSidedDots {
    const SizedDots& dots;  ///< sizes, and the grounds on which the dots lie
    unsigned flips;         ///< one bit for each channel that the dots flip
    const Grounds& grounds;
};

/// Dots of an ink, of a kind, or of a class of a dot map, as writers receive them. All objects to which this object
/// refers must outlive it.
struct InkDots {
    const Ink& ink;  ///< name and colour of the ink, kind or class; the name is empty if answers do not name it
    const Distribution& dots;
    double radius = 0;                        ///< radius of each dot, in the units of the points; used only by drawings
    const TwoSidedDots* two_sides = nullptr;  ///< null: all dots are ink, of one size
    /// [points] Index of each point's feature, in ascending order; empty if points are not grouped by features.
    std::span<const std::uint32_t> features = {};
};

/// Calls function(channel) for each channel whose bit is set.
template <class Function>
void for_channels(unsigned bits, const Function& function) {
    for (std::size_t channel = 0; bits >> channel != 0; ++channel) {
        if ((bits >> channel & 1) != 0) function(channel);
    }
}

/// Returns the ranks of `count` points from the point `first` on; empty if the points have no ranks.
inline std::span<const std::uint32_t> ranks_of(const Distribution& points, std::size_t first, std::size_t count) {
    const std::span<const std::uint32_t> all = points.ranks;
    return all.empty() ? all : all.subspan(first, count);
}

}  // namespace ccdt::api

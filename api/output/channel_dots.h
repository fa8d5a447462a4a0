// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/input/palette.h"
#include "api/output/point_set.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// The dots of all kinds that flip one channel, in a drawing with dots on both sides of the tonal scale. Lengths are in
/// the units of the points.
struct ChannelDots {
    std::vector<Point> points;
    std::vector<float> radii;
    std::vector<std::uint32_t> ink;    ///< indices of dots on white ground
    std::vector<std::uint32_t> paper;  ///< indices of dots on black ground; a dot on the boundary is in both lists
};

inline ChannelDots dots_of_channel(const PointSet& kinds, std::size_t channel) {
    ChannelDots all;
    for (const InkDots& kind : kinds.layers) {
        const auto& [dots, flips, grounds] = *kind.two_sides;
        if ((flips >> channel & 1) == 0) continue;
        const auto first = static_cast<std::uint32_t>(all.points.size());
        all.points.insert(all.points.end(), kind.dots.points.begin(), kind.dots.points.end());
        all.radii.insert(all.radii.end(), dots.radii.begin(), dots.radii.end());
        for (std::uint32_t i = 0; i < kind.dots.points.size(); ++i) {
            const bool is_ink = (dots.white[i] >> channel & 1) != 0, is_cut = (dots.cut[i] >> channel & 1) != 0;
            if (is_ink || is_cut) all.ink.push_back(first + i);
            if (!is_ink || is_cut) all.paper.push_back(first + i);
        }
    }
    return all;
}

/// Returns the colour of the paper dots of a channel. Channels with names are mixed with each other; their paper dots
/// have the colour that leaves the other channels unchanged.
inline Colour paper_dot_colour(const PointSet& kinds, const Palette& palette) {
    if (!kinds.are_named()) return palette.paper;
    return palette.mixing == Mixing::Add ? kBlack : kWhite;
}

}  // namespace ccdt::api

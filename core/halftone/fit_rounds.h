// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/sized_dots.h"

namespace ccdt {

/// Fits the areas of dots in rounds, and returns the sizes of the dots.
///
/// @param sizes  a fit with the functions improve(), find_cut(), areas(), white_channels() and cut_channels()
/// @param sites  [kinds][sites]; the fit numbers the dots in this order
/// @param fit    false: the areas stay as planned
/// @param stop   polled once per round; after a stop, the result has the areas of the completed rounds
template <class Fit>
std::vector<SizedDots> fit_in_rounds(Fit& sizes, std::span<const std::vector<Point>> sites, bool fit,
                                     const std::stop_token& stop) {
    constexpr int kRounds = 14, kRoundsOfCut = 4;
    for (int round = 0; fit && round < kRounds && !stop.stop_requested(); ++round) {
        if (round > 0 && round % kRoundsOfCut == 0) sizes.find_cut();
        sizes.improve();
    }
    sizes.find_cut();
    std::vector<SizedDots> dots(sites.size());
    std::size_t dot = 0;
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        for (std::size_t i = 0; i < sites[kind].size(); ++i, ++dot) {
            const double area = static_cast<double>(sizes.areas()[dot]);
            dots[kind].radii.push_back(static_cast<float>(std::sqrt(area / std::numbers::pi)));
            dots[kind].white.push_back(static_cast<std::uint8_t>(sizes.white_channels(dot)));
            dots[kind].cut.push_back(static_cast<std::uint8_t>(sizes.cut_channels(dot)));
        }
    }
    return dots;
}

}  // namespace ccdt

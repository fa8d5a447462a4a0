// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/reduction.h"

namespace ccdt {

/// Simulates a print of dots in several inks and compares its local mean light with the wanted picture.
///
/// The dots of each ink are spread evenly. But the overlap of inks varies, which is visible as blotches many dots wide.
/// A dot that moves uncovers one area and covers another. The mean light changes if another ink lies on only one of
/// these two areas. So moves of a few hundredths of a radius suffice to correct the light of all inks together.
class PrintProof {
public:
    /// @param light          [cells] the wanted light, within the gamut of the inks
    /// @param cells          grid of `light`: either the picture's pixels or the cells of resolved_cells()
    /// @param width, height  size of the picture in pixels, >= 1
    /// @param radius         radius of all dots in pixels, > 0
    /// @param sites          number of dots of all inks together; limits the number of samples and thus the memory
    PrintProof(const LightPlanes& light, const CellGrid& cells, int width, int height, const InkSet& inks,
               double radius, std::size_t sites, Executor& executor = inline_executor());

    /// Computes the moves of a retouch round: one step of steepest descent. The step reduces the squared
    /// ColourDifference between print and picture, after both are blurred over about three radii.
    ///
    /// @param sites  [inks] in pixels; y points down
    /// @param stop   polled regularly; after a stop, the remaining moves are zero
    /// @returns      [inks][sites] moves of at most 0.15 radii; all zero if dots cover less than 6 % of the picture
    ///
    /// Deterministic for any number of threads. O(sites).
    std::vector<std::vector<Point>> moves(std::span<const std::vector<Point>> sites, const std::stop_token& stop = {},
                                          Executor& executor = inline_executor()) const;

private:
    using Channels = Overprint::Channels;

    template <class LightAt>
    LightPlanes means(const LightAt& light_at, Executor& executor) const;
    template <class LightAt>
    Channels mean(const LightAt& light_at, int column, int row) const;
    std::vector<std::uint8_t> printed_samples(std::span<const std::vector<Point>> sites, const std::stop_token& stop,
                                              Executor& executor) const;
    LightPlanes gradients(const std::vector<std::uint8_t>& samples, Executor& executor) const;
    Point move(Point site, unsigned ink, const std::vector<std::uint8_t>& samples, const LightPlanes& gradients) const;

    double radius_;                       ///< pixels
    double step_;                         ///< pixels per sample
    int width_ = 0, height_ = 0;          ///< samples
    int columns_ = 0, rows_ = 0;          ///< cells of kCell x kCell samples, to compare light; 0 if no dot moves
    std::array<Point, 24> directions_{};  ///< unit vectors in equally spaced directions
    std::vector<Channels> colours_;       ///< [2^inks] colour of each combination of inks, given as a set of bits
    LightPlanes wanted_;                  ///< [cells] mean wanted light
};

}  // namespace ccdt

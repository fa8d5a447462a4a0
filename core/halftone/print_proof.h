// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Trial print of dots in several inks, which is compared with what shall be seen.
///
/// Each ink by itself is spread evenly, but how inks overlap varies from place to place, and shows as blotches many
/// dots wide. A dot that moves lays bare what is behind it and covers what is before it: where nothing else lies there
/// that changes nothing in the mean, but where the one is covered already by another ink and the other is not, it does.
/// So moves of a few hundredths of a radius suffice to make the light of all inks together what it should be.
class PrintProof {
public:
    /// @param light          [cells] what shall be seen, as far as inks can make it
    /// @param cells          of the picture; pixels, or what is as good for such dots
    /// @param width, height  pixels, >= 1
    /// @param radius         of all dots, pixels, > 0
    /// @param sites          how many dots there are, of all inks; bounds the memory
    PrintProof(const LightPlanes& light, const CellGrid& cells, int width, int height, const InkSet& inks,
               double radius, std::size_t sites, Executor& executor = inline_executor());

    /// Computes the moves of a round: a step of steepest descent on the squared difference of what is seen, by
    /// ColourDifference, blurred over about three radii.
    ///
    /// @param sites  [inks] in pixels, y as rows go
    /// @param stop   asked now and then; the rest is not moved, then
    /// @returns      [inks][sites], none longer than a seventh of a radius; none at all where dots are so few on a
    ///               large picture that they hardly meet
    /// Same input, same bytes, whatever the executor. O(sites).
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
    LightPlanes pulls(const std::vector<std::uint8_t>& samples, Executor& executor) const;
    Point move(Point site, unsigned ink, const std::vector<std::uint8_t>& samples, const LightPlanes& pulls) const;

    double radius_;                  ///< pixels
    double step_;                    ///< pixels a sample
    int width_ = 0, height_ = 0;     ///< samples
    int columns_ = 0, rows_ = 0;     ///< cells, in which what is seen is compared
    std::array<Point, 24> ways_{};   ///< directions all around a dot
    std::vector<Channels> colours_;  ///< by the inks that lie on each other, as bits
    LightPlanes wanted_;             ///< [cells]
};

}  // namespace ccdt

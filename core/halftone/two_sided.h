// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Options of a halftone with dots on both sides of the tonal scale.
struct TwoSidedOptions {
    std::optional<std::size_t> sites;  ///< number of dots, >= 1
    std::optional<double> radius;      ///< of the largest dots, in cells, > 0; one of the two at least
    double detail = 0;                 ///< in [0, 1]; how far edges are emphasised
    double least_radius = 0;           ///< radius in cells below which no dot is planned, as far as that is possible
    std::optional<std::size_t> most = std::nullopt;  ///< number of dots beyond which they are larger than `radius`
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

}  // namespace ccdt

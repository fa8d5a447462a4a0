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
    std::optional<double> radius;      ///< radius of the largest dots, in cells, > 0; required if there is no `sites`
    double detail = 0;                 ///< strength of the sharpening of edges, in [0, 1]
    /// Lower limit of the radii, in cells. If even the largest dots are smaller, all dots have the same size.
    double min_radius = 0;
    /// Maximum number of dots. If more dots of the given radius were needed, the radius is increased.
    std::optional<std::size_t> max_sites = std::nullopt;
};

/// Returns the area that dots have to flip, in cells. Each cell adds the largest min(c, 1 - c) of its channel values c.
/// @param light  [channels][cells] in [0, 1]
double minority_area(std::span<const std::vector<float>> light, Executor& executor = inline_executor());

/// Divides the picture into grounds and plans the dots.
///
/// Chooses the areas of dots such that the pattern is least visible. If rho dots per area cover the share c, their
/// contrast after a blur is c V exp(-k rho), with a constant k. The visibility V is the colour difference in CIELAB per
/// flipped share, or for grey the slope of lightness. For a given number of dots, the total contrast is least if rho is
/// proportional to log(1 + c V / mu), with a constant mu. So dots are smaller where V is large, as in shadows, and
/// where c is small, as in highlights and for rare kinds.
///
/// @param light  [1 or 3][cells] in [0, 1], linear light
/// @param stop   polled between steps; after a stop the result must not be used
/// Deterministic for any number of threads. O(cells).
TwoSidedPlan plan_two_sided(std::vector<std::vector<float>> light, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop = {},
                            Executor& executor = inline_executor());

/// A picture to be printed in several inks.
struct InkPicture {
    std::vector<std::vector<float>> coverage;  ///< [inks][cells] share that each ink covers; determines the grounds
    LightPlanes light;                         ///< wanted light
};

/// Plans a halftone in several inks. Each ink is a channel, and its black ground is solid ink.
///
/// The colour of a place depends on the set of inks printed there. So the flipped areas of the channels need not be
/// nested. In each cell, the kinds cover the shares whose mean colour is nearest to the picture (KindMixture). Only the
/// kMaxInkKinds kinds with the largest total area are used.
///
/// @param inks  1 to kMaxInks inks, converted to the same tone as the picture's light by toned()
TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop = {},
                            Executor& executor = inline_executor());

}  // namespace ccdt

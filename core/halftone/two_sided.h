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
    double min_radius =
        0;  ///< lower limit of the radii, in cells; if the largest dots are smaller, all have their size
    /// Maximum number of dots. If more dots of the given radius were needed, the radius is increased.
    std::optional<std::size_t> max_sites = std::nullopt;
};

/// Returns the area that dots have to flip, in cells. In a cell, this is the largest min(c, 1 - c) of all channels c.
/// @param light  [channels][cells] in [0, 1]
double minority_area(std::span<const std::vector<float>> light, Executor& executor = inline_executor());

/// Divides the picture into grounds and plans the dots.
///
/// The areas of the dots are chosen such that the pattern is least visible. Consider dots of one kind with the density
/// rho that cover the share c. After a blur, their contrast is c V exp(-k rho), with a constant k. Here, V is the
/// visibility: the colour difference in CIELAB per share that is flipped, or for grey the slope of lightness. For a
/// given number of dots, the sum of the contrast is least if rho is proportional to log(1 + c V / mu), with a constant
/// mu. So dots are smaller in shadows, where paper dots are conspicuous, in highlights, and for rare kinds.
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

/// Plans the dots of inks. Each ink is a channel, and its black ground is solid ink.
///
/// Inks are printed over each other, so the colour depends on the set of inks at a place, and the flipped areas need
/// not be nested. At each place, the shares of the kinds are those whose mean colour is nearest to the picture
/// (KindMixture). Only the kMaxInkKinds kinds with the largest area are used.
///
/// @param inks  1 to kMaxInks inks, converted to the same tone as the picture's light by toned()
TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop = {},
                            Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/polish/settings.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/reduction.h"

namespace ccdt {

/// Largest number of sets of inks that a drawing uses.
inline constexpr std::size_t kMaxInkSets = 8;

/// Share of a picture that the dots and holes of a field are assumed to draw, as the argument of resolved_cells(). The
/// true share is measured in these cells. In darker and lighter pictures it is smaller, but smaller dots need no finer
/// cells.
inline constexpr double kDrawnShare = 0.25;

/// Options of a drawing by one field.
struct FieldOptions {
    std::optional<std::size_t> sites;  ///< number of sites, >= 1
    std::optional<double> radius;      ///< radius of the largest dots, in cells, > 0; required if there is no `sites`
    double detail = 1;                 ///< strength of the sharpening, in [0, 1]
    /// Smallest area of a dot or a hole, in cells, >= 0. Where dots or holes would be smaller, there are fewer.
    double least_area = 0;
    /// Maximum number of sites that may follow from the radius.
    std::optional<std::size_t> max_sites = std::nullopt;
};

/// A boundary between two colours of a drawing. The darker colour lies where the spot function exceeds 1 minus the
/// darker colour's share. All values are given for cells of the picture.
struct FieldChannel {
    std::vector<float> light;      ///< share of the lighter colour, in [0, 1]
    std::vector<float> sharp;      ///< the same after denoising and sharpening, not limited
    std::vector<float> steepness;  ///< factor of the contrast, >= 1; larger at edges of the picture
    std::vector<float> low;        ///< minimum of `sharp` in the nearest cells
    std::vector<float> high;       ///< maximum of `sharp` in the nearest cells
};

/// Returns a value of `sharp` with a larger contrast.
/// @param low, high  extremes around it, which the result exceeds only if they lie beyond solid ink or bare paper:
///                   strokes are drawn without holes
inline float steepened(float value, float steepness, float low, float high) {
    constexpr float kBeyond = 6, kLowest = -1, kHighest = 2;
    const float middle = (low + high) / 2;
    const float least = low < 0 ? std::max(kBeyond * low, kLowest) : low;
    const float most = high > 1 ? std::min(1 + kBeyond * (high - 1), kHighest) : high;
    return std::clamp(middle + (value - middle) * steepness, least, most);
}

/// Plan of a drawing by one field: the density of the sites, and what their spot function is compared with.
struct FieldPlan {
    CellGrid cells;
    std::vector<FieldChannel> channels;  ///< grey; or red, green and blue; or the boundaries between `sets`
    /// Sets of inks, as bits, from dark to light. From one set to the next, the spot function falls. Empty if channels
    /// are independent of each other.
    std::vector<unsigned> sets;
    std::vector<float> density;  ///< [cells] sites per cell, up to a factor
    double sites = 0;            ///< number of sites, as requested or from the radius; 0 for a picture of
                                 ///< bare paper and solid ink only
    bool is_limited = false;     ///< whether dots and holes have a smallest area, so that their spacing varies widely
    double radius = 0;           ///< radius of dots that cover half of an area of luminance 1/2, in cells

    /// Returns the mean distance of neighbouring sites, in cells: the side of a square of the mean area.
    double pitch() const;
};

/// Returns the quality at which the sites of a drawing by one field are placed. Only Best has a polish: a drawing gains
/// little from evener distances, since its dots and holes follow the triangles, whose capacities are equal.
constexpr Quality quality_of_sites(Quality quality) {
    return quality == Quality::Standard ? Quality::Draft : quality;
}

/// Returns the area that dots and holes have to draw, in cells. Each cell adds the largest min(c, 1 - c) of its channel
/// values c.
/// @param light  [channels][cells] in [0, 1]
double minority_area(const std::vector<std::vector<float>>& light, Executor& executor = inline_executor());

/// Plans the sites of a drawing.
///
/// The density makes the pattern of dots least visible: it is proportional to log(1 + c V / mu), where the dots cover
/// the share c, and V is the slope of lightness. This assumes that the contrast of a pattern with the density rho is c
/// V exp(-k rho) after a blur. In shadows, which have two holes for each site, the density is smaller.
///
/// @param light  [1 or 3][cells] linear light, in [0, 1]
/// @param stop   polled between steps; after a stop the plan must not be used
/// Deterministic for any number of threads. O(cells).
FieldPlan plan_field(std::vector<std::vector<float>> light, const CellGrid& cells, const FieldOptions& options,
                     const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Plans a drawing in several inks, by the shares of sets of inks that InkMixture chooses.
/// @param light  wanted light
/// @param inks   1 to kMaxInks inks
FieldPlan plan_field(LightPlanes light, const InkSet& inks, const CellGrid& cells, const FieldOptions& options,
                     const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt

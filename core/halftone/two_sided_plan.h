// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/bilinear.h"
#include "core/halftone/ground.h"
#include "core/halftone/overprint.h"
#include "core/halftone/reduction.h"

namespace ccdt {

/// Returns the number of possible kinds of dots: the number of non-empty sets of channels.
constexpr std::size_t kinds_of(std::size_t channels) {
    return (std::size_t{1} << channels) - 1;
}

/// Returns the channels that dots of a kind flip, as bits.
constexpr unsigned flips_of(std::size_t kind) {
    return static_cast<unsigned>(kind) + 1;
}

/// Largest number of kinds that a plan for inks uses.
inline constexpr std::size_t kMaxInkKinds = 15;

/// A channel of a picture, divided into grounds.
struct TwoSidedChannel {
    Ground ground;
    std::vector<float> light;  ///< [dot cells] light of the picture; for an ink, the share left bare
    std::vector<float> white;  ///< [dot cells] share of white ground
};

/// Dots that flip the same channels.
struct KindOfDots {
    unsigned flips = 0;          ///< channels, as bits
    std::vector<float> density;  ///< [dot cells] dots per area, up to a factor; 0 everywhere if the kind has no dots
    std::vector<float> area;     ///< [dot cells] area of a dot at this position, in cells
    double share = 0;            ///< sum of `density` over all dot cells; the number of dots, up to a factor
};

/// Plan of a halftone with ink dots on white ground and paper dots on black ground.
///
/// White ground has the light 1 in a channel, black ground 0. Where the picture has the light Y, ink dots cover the
/// share 1 - Y of white ground, or paper dots cover the share Y of black ground. Both shares are at most about one
/// half. So dots hardly ever overlap, and the covered share is the number of dots per area times the area of a dot.
///
/// In red, green and blue, the flipped areas of the channels are nested. A place has up to three kinds of dots. The
/// first flips all three channels. The second flips the two channels with the larger flipped areas. The third flips the
/// channel with the largest flipped area. So all dots together cover only the largest area, without overlap.
///
/// The grounds are given in small cells, because their boundaries are drawn precisely. All properties of dots are given
/// in larger cells, the dot cells, whose side is about half the spacing of dots.
struct TwoSidedPlan {
    CellGrid cells;                         ///< of the grounds; the unit of positions, areas and radii
    CellGrid dot_cells;                     ///< along each axis at most as many as `cells`
    std::vector<TwoSidedChannel> channels;  ///< grey; or red, green and blue; or one for each ink
    std::vector<KindOfDots> kinds;          ///< sorted by `flips`
    double dots = 0;                        ///< number of dots needed at the areas in `kinds`; 0 if the ground suffices
    double radius = 0;                      ///< radius of the largest dots, in cells
    bool is_nested = true;  ///< whether flipped areas of channels are nested; if not, kinds mix in any shares
    /// [2^channels] light of each set of inks; empty if fit_light() is not used.
    std::vector<std::array<float, 3>> colours;
    LightPlanes wanted;  ///< [dot cells] light of the picture; empty if fit_light() is not used

    /// Returns the number of dot cells per cell, along each axis.
    Point scale() const {
        return {static_cast<double>(dot_cells.columns) / cells.columns,
                static_cast<double>(dot_cells.rows) / cells.rows};
    }

    /// Returns the area of a dot cell, in cells.
    double dot_cell_area() const { return 1 / (scale().x * scale().y); }

    /// Interpolates values that are given for dot cells.
    /// @param values  [dot cells]
    /// @param place   in cells
    float at(const std::vector<float>& values, Point place) const {
        return interpolated(values, dot_cells.columns, dot_cells.rows, {scale().x * place.x, scale().y * place.y});
    }
};

/// Returns the channels whose ground is black in the larger part of a dot cell, as bits.
inline unsigned black_channels(const TwoSidedPlan& plan, std::size_t cell) {
    unsigned bits = 0;
    for (std::size_t c = 0; c < plan.channels.size(); ++c)
        bits |= static_cast<unsigned>(!(plan.channels[c].white[cell] > 0.5f)) << c;
    return bits;
}

}  // namespace ccdt

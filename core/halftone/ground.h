// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/dots.h"
#include "core/halftone/reduction.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Division of one channel of a picture into white ground (bare paper) and black ground (solid ink).
///
/// The ground is white where a function, the level, exceeds 1/2. The level is stored at the centres of cells and
/// interpolated bilinearly between them, so the boundary is more precise than the cells. Beyond the outermost centres,
/// the level is constant. Positions are in cells: x counts columns, y counts rows.
class Ground {
public:
    /// @param level  value at the centre of each cell [columns * rows], finite
    Ground(std::vector<float> level, const CellGrid& cells);

    const CellGrid& cells() const { return cells_; }
    const std::vector<float>& level() const { return level_; }

    bool is_white(Point place) const;

    /// Returns a copy in which white and black ground are exchanged.
    Ground inverse() const;

    /// Returns the share of each part of the picture that is white, in [0, 1]. It is exactly 0 or 1 where no boundary
    /// is near.
    /// @param parts  division of the picture into parts of equal size, at most as many as cells along each axis
    /// @returns      [parts.columns * parts.rows]
    std::vector<float> white_shares(const CellGrid& parts, Executor& executor = inline_executor()) const;

    /// Converts the share of each pixel that dots flip to the share that ink covers. The two shares are equal on white
    /// ground; on black ground, they add up to 1.
    ///
    /// @param flipped    raster of the whole picture: coverage by dots, replaced by coverage by ink
    /// @param scale      canvas pixels per cell, across and down
    /// @param antialias  whether a boundary divides pixels; if not, each pixel gets the ground at its centre
    void apply(Raster& flipped, Point scale, bool antialias, Executor& executor = inline_executor()) const;

private:
    CellGrid cells_;
    std::vector<float> level_;
};

/// Divides each channel of a picture into white and black ground. The light differs from the ground (1 or 0) by at most
/// about one half. The boundary is short and smooth, follows edges, and omits specks that dots can draw.
///
/// First, the light is sharpened, so that thin strokes of text become black ground even if their light exceeds 1/2.
/// Then the light is smoothed by denoised(), more strongly for larger dots. Where red, green and blue differ little,
/// they share one ground, so that greys have no coloured fringes.
///
/// @param light   [channels][columns * rows] in [0, 1], linear light of each cell
/// @param radius  radius of the dots, in cells, > 0
/// @param detail  strength of the sharpening, in [0, 1]
/// @param is_rgb  whether the channels are red, green and blue
/// @returns       [channels]
/// Deterministic for any number of threads. O(cells).
std::vector<Ground> divide_ground(std::span<const std::vector<float>> light, const CellGrid& cells, double radius,
                                  double detail, bool is_rgb, Executor& executor = inline_executor());

}  // namespace ccdt

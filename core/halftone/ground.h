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

/// Division of a picture into white ground, which is the bare paper, and black ground, which is solid ink.
///
/// The ground is white where a level is above 1/2. The level is given at the centres of cells and interpolated
/// bilinearly between them; beyond the outermost centres it is constant. So the boundary is a smooth curve, which is
/// more precise than the cells. Positions are in cells: x counts columns, y counts rows.
class Ground {
public:
    /// @param level  [columns * rows], finite
    Ground(std::vector<float> level, const CellGrid& cells);

    const CellGrid& cells() const { return cells_; }
    const std::vector<float>& level() const { return level_; }

    bool is_white(Point place) const;

    /// Returns the ground that is black where this one is white.
    Ground inverse() const;

    /// Returns the share of each part of the picture that is white, in [0, 1]. It is exactly 0 or 1 where no boundary
    /// is near.
    /// @param parts  division of the picture into parts of equal size, at most as many as cells along each axis
    /// @returns      [columns * rows] of `parts`
    std::vector<float> white_shares(const CellGrid& parts, Executor& executor = inline_executor()) const;

    /// Converts the share of each pixel that dots flip to the share that ink covers. The two shares are equal on white
    /// ground; on black ground, they add up to 1.
    ///
    /// @param flipped    coverage by dots, on a canvas that shows the whole picture; modified
    /// @param scale      canvas pixels per cell, across and down
    /// @param antialias  false: a whole pixel has the ground at its centre
    void apply(Raster& flipped, Point scale, bool antialias, Executor& executor = inline_executor()) const;

private:
    CellGrid cells_;
    std::vector<float> level_;
};

/// Divides each channel of a picture into white and black ground. The difference |light - ground| is at most about one
/// half. The boundary is short and smooth, follows the edges of the picture, and leaves out specks that dots can draw.
///
/// First, the light is sharpened. Thin strokes of text then belong to the ground even if they are closer to the paper
/// than to black. Then the light is smoothed by denoised(), more strongly for larger dots. Where red, green and blue
/// differ little, they share one ground, so that greys have no coloured fringes.
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

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
/// A level is given at the centres of cells and interpolated bilinearly between them; beyond the outermost centres it
/// is constant. The ground is white where the level is above 1/2, so its boundary is a smooth curve that is finer than
/// the cells. Places are in cells, x along the columns, y down the rows.
class Ground {
public:
    /// @param level  [columns * rows], finite
    Ground(std::vector<float> level, const CellGrid& cells);

    const CellGrid& cells() const { return cells_; }
    const std::vector<float>& level() const { return level_; }

    bool is_white(Point place) const;

    /// Returns the ground that is black where this one is white.
    Ground inverse() const;

    /// Returns the share of each cell that is white [columns * rows], in sixteenths.
    std::vector<float> white_shares(Executor& executor = inline_executor()) const;

    /// Turns the shares of pixels that dots flip into the shares that ink covers: of white ground as many, of black
    /// ground the rest.
    ///
    /// @param flipped    drawn on a canvas that shows the whole picture
    /// @param scale      canvas pixels per cell, across and down
    /// @param antialias  false: a pixel has the ground of its centre
    void apply(Raster& flipped, Point scale, bool antialias, Executor& executor = inline_executor()) const;

private:
    CellGrid cells_;
    std::vector<float> level_;
};

/// Divides each channel of a picture into white and black ground such that |light - ground| is at most about one half,
/// along a boundary that is short and smooth, follows the picture's edges, and leaves out specks which dots can draw.
///
/// Light is sharpened by `detail` before, so that thin strokes of text belong to the ground even where they are nearer
/// to the paper than to black. Then it is denoised() by total variation, stronger for larger dots. Where red, green and
/// blue differ little they have one ground, lest greys have coloured fringes.
///
/// @param light   [channels][columns * rows] in [0, 1], linear light of each cell
/// @param radius  of the dots, in cells, > 0
/// @param detail  in [0, 1]
/// @param is_rgb  the channels are red, green and blue
/// @returns       [channels]
/// Same input, same bytes, on any executor. O(cells).
std::vector<Ground> divide_ground(std::span<const std::vector<float>> light, const CellGrid& cells, double radius,
                                  double detail, bool is_rgb, Executor& executor = inline_executor());

}  // namespace ccdt

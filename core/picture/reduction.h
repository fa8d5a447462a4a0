// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/executor.h"
#include "core/picture/picture.h"

namespace ccdt {

/// Division of a picture into cells of equal size. The sides of cells need not be whole numbers of pixels.
struct CellGrid {
    int columns = 0;
    int rows = 0;

    friend bool operator==(const CellGrid&, const CellGrid&) = default;
};

/// Chooses cells that dots of the given radius cannot resolve. Sides of cells are half a radius, or less if the shorter
/// side of the picture would have fewer than 64 cells. If the sides would be below two pixels, the cells are the
/// pixels.
///
/// Measured on three photographs at 1,000 and 2,300 dots: noise at each scale, evenness and distances are the same as
/// without reduction, or some tenths of a decibel better. With sides of 0.7 radii and more, all three get worse.
///
/// @param width, height  pixels, >= 1
/// @param radius         pixels, >= 0
CellGrid resolved_cells(int width, int height, double radius);

/// Returns the mean of an image over each cell. Pixels are weighted by the share of their area in the cell.
///
/// @param values  [width * height]
/// @param cells   along each axis at most as many as there are pixels
/// @returns       [columns * rows]
/// Deterministic for any number of threads. O(pixels).
std::vector<float> reduced(const std::vector<float>& values, int width, int height, const CellGrid& cells,
                           Executor& executor = inline_executor());

/// Returns the alpha-weighted mean light over each cell, so that a cell looks like its pixels on paper of any colour.
ColourPicture reduced(const ColourPicture& picture, const CellGrid& cells, Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/halftone/picture.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Cells that a picture is divided into: columns and rows, all of one size, which need not be whole pixels.
struct CellGrid {
    int columns = 0;
    int rows = 0;

    friend bool operator==(const CellGrid&, const CellGrid&) = default;
};

/// Chooses cells that dots of a radius do not tell from pixels: half a radius a side, but 64 along the shorter side at
/// least. Where such cells would be of less than two pixels each way they are the pixels themselves. Measured on three
/// photographs at 1,000 and 2,300 dots: noise at each scale, evenness and distances are as without, or better by some
/// tenths of a decibel; of 0.7 radii and more they get worse.
///
/// @param width, height  pixels, >= 1
/// @param radius         pixels, >= 0
CellGrid resolved_cells(int width, int height, double radius);

/// Takes the mean over each cell: the sum over all cells, times their area, is that over all pixels, to rounding.
///
/// @param values  [width * height]
/// @param cells   not more than there are pixels, either way
/// @returns       [columns * rows]
/// Same input, same bytes, whatever the executor. O(pixels).
std::vector<float> reduced(const std::vector<float>& values, int width, int height, const CellGrid& cells,
                           Executor& executor = inline_executor());

/// Takes the mean light over each cell, pixels counting by their alpha: what is seen of it on any paper stays.
ColourPicture reduced(const ColourPicture& picture, const CellGrid& cells, Executor& executor = inline_executor());

}  // namespace ccdt

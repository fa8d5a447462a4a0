// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// An edge of an area's border, with the area on its left.
struct BorderEdge {
    Point from, to;
    double weight = 1;  ///< weight of the area; equal for all its edges
};

/// Some cells of a grid: in each row, all cells from the first to the last cell that a border crosses.
struct CrossedCells {
    struct Row {
        std::size_t first = 0, end = 0;  ///< columns [first, end); first == end if no border crosses the row
        std::size_t number = 0;          ///< index of the row's first cell in `values`
    };
    std::vector<Row> rows;
    std::vector<double> values;  ///< values of the cells, row by row
};

/// Computes the share of each cell that areas cover, times the weights of the areas. Exact except for rounding. Cells
/// outside the listed ranges are not covered.
/// @param sides  size of the box over which the grid is stretched; the box's lower left corner is the origin
///
/// O(rows + listed cells).
CrossedCells crossed_coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows);

/// Computes the share of every cell that areas cover, times the weights of the areas [rows * columns]. O(cells).
std::vector<double> coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows);

}  // namespace ccdt

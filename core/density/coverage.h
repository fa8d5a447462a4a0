#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// An edge of an area's border, the area on its left.
struct BorderEdge {
    Point from, to;
    double weight = 1;  ///< by which the area counts; the same all around it
};

/// Cells of a grid, of each row all from the first to the last one that some border crosses.
struct CrossedCells {
    struct Row {
        std::size_t first = 0, end = 0;  ///< columns; none if they are the same
        std::size_t number = 0;          ///< of its first cell
    };
    std::vector<Row> rows;
    std::vector<double> values;  ///< of the cells, row by row
};

/// Share of the cells that areas cover, each times its weight, to rounding; all others are not covered.
/// @param sides  of the box that the grid is stretched over, its corner at the origin
/// O(rows + cells between those that the border crosses).
CrossedCells crossed_coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows);

/// The same of all cells [rows * columns]. O(cells + those that the border crosses).
std::vector<double> coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows);

}  // namespace ccdt

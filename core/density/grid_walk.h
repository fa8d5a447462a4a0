// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "core/geometry/point.h"

namespace ccdt {

/// Cuts the segment ab at the lines of a grid of unit cells. Calls `visit(column, row, x, dy)` for each piece, with the
/// piece's cell, the abscissa of its midpoint and its signed height. The heights add up to b.y - a.y. A horizontal
/// segment has no pieces.
///
/// @param columns, rows  size of the grid in cells, which contains the segment; points on its right and upper sides
///                       belong to the last cells
template <class Visit>
inline void walk_cells(Point a, Point b, int columns, int rows, Visit&& visit) {
    const double height = b.y - a.y;
    if (height == 0) return;
    const double width = b.x - a.x;
    const double slope = width / height;
    const double rise = width != 0 ? height / width : 0;  // unused if the segment stays in one column
    const int step = height > 0 ? 1 : -1;
    // Rounding can put a point just below 0; truncation then assigns the point to cell 0, which is correct.
    const int last_row = std::min(static_cast<int>(b.y), rows - 1);
    int row = std::min(static_cast<int>(a.y), rows - 1);
    int column = std::min(static_cast<int>(a.x), columns - 1);
    double x0 = a.x, y0 = a.y;
    for (;; row += step) {
        const bool ends = row == last_row;
        const double y1 = ends ? b.y : static_cast<double>(step > 0 ? row + 1 : row);
        const double x1 = ends ? b.x : a.x + (y1 - a.y) * slope;
        const int last_column = std::min(static_cast<int>(x1), columns - 1);
        double x = x0, remaining = y1 - y0;
        while (column != last_column) {
            const int next = column < last_column ? column + 1 : column - 1;
            const auto line = static_cast<double>(std::max(column, next));
            const double piece = (line - x) * rise;
            visit(column, row, (x + line) / 2, piece);
            remaining -= piece;
            x = line;
            column = next;
        }
        visit(column, row, (x + x1) / 2, remaining);
        if (ends) return;
        x0 = x1;
        y0 = y1;
    }
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/coverage.h"

#include <algorithm>
#include <cstdint>

#include "core/density/grid_walk.h"

namespace ccdt {

namespace {

/// A piece of an edge within one cell.
struct Piece {
    std::uint32_t row, column;
    double share;    ///< share of the cell between the piece and the cell's left side
    double left_of;  ///< share that the piece adds to every cell on its left in the row
};

std::vector<Piece> pieces_of(std::span<const BorderEdge> border, Point scale, int columns, int rows) {
    std::vector<Piece> pieces;
    pieces.reserve(2 * border.size());
    for (const auto& [a, b, weight] : border) {
        walk_cells({a.x * scale.x, a.y * scale.y}, {b.x * scale.x, b.y * scale.y}, columns, rows,
                   [&, w = weight](int column, int row, double x, double dy) {
                       pieces.push_back({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column),
                                         w * (x - column) * dy, w * dy});
                   });
    }
    return pieces;
}

}  // namespace

CrossedCells crossed_coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows) {
    const auto pieces = pieces_of(border, {columns / sides.x, rows / sides.y}, columns, rows);
    CrossedCells cells{std::vector<CrossedCells::Row>(static_cast<std::size_t>(rows)), {}};
    for (const Piece& piece : pieces) {
        CrossedCells::Row& row = cells.rows[piece.row];
        const std::size_t column = piece.column;
        row = row.end == 0 ? CrossedCells::Row{column, column + 1}
                           : CrossedCells::Row{std::min(row.first, column), std::max(row.end, column + 1)};
    }
    std::size_t count = 0;
    for (CrossedCells::Row& row : cells.rows) {
        row.number = count;
        count += row.end - row.first;
    }
    cells.values.assign(count, 0);
    std::vector<double> left_of(count, 0);
    for (const Piece& piece : pieces) {
        const CrossedCells::Row& row = cells.rows[piece.row];
        const std::size_t cell = row.number + piece.column - row.first;
        cells.values[cell] += piece.share;
        left_of[cell] += piece.left_of;
    }
    for (const CrossedCells::Row& row : cells.rows) {
        double from_right = 0;
        for (std::size_t cell = row.number + row.end - row.first; cell-- > row.number;) {
            cells.values[cell] += from_right;
            from_right += left_of[cell];
        }
    }
    return cells;
}

std::vector<double> coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows) {
    const CrossedCells cells = crossed_coverage(border, sides, columns, rows);
    const auto width = static_cast<std::size_t>(columns);
    std::vector<double> share(width * cells.rows.size(), 0);
    for (std::size_t number = 0; number < cells.rows.size(); ++number) {
        const CrossedCells::Row& row = cells.rows[number];
        const auto begin = cells.values.begin() + static_cast<std::ptrdiff_t>(row.number);
        std::copy(begin, begin + static_cast<std::ptrdiff_t>(row.end - row.first),
                  share.begin() + static_cast<std::ptrdiff_t>(number * width + row.first));
    }
    return share;
}

}  // namespace ccdt

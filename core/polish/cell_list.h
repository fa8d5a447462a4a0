// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the points near a place by means of a grid with about one point per cell. Each crowded cell has a nested grid.
class CellList {
public:
    /// @param places  [n >= 1], in the domain's bounding box; on a torus, wrapped into it
    ///
    /// O(points), multiplied by the depth of nested grids.
    CellList(const Domain& domain, std::span<const Point> places);

    /// Calls function(point, number) for each point that may be within `reach` of p. Some points farther away may be
    /// included. `number` is the index of the point in `places`. On a torus, `point` is the copy nearest to p.
    /// @param reach  > 0
    template <class Function>
    void for_near(Point p, double reach, Function&& function) const {
        const Grid& grid = grids_.front();
        const Range x = around(p.x, reach, grid.x), y = around(p.y, reach, grid.y);
        for (int j = y.first; j <= y.last; ++j) {
            for (int i = x.first; i <= x.last; ++i) {
                const int column = wrapped(i, grid.x.cells), row = wrapped(j, grid.y.cells);
                const Point shift{(i - column) / grid.x.cells * sides_.x, (j - row) / grid.y.cells * sides_.y};
                look_into(grid.cell(column, row), p, reach, shift, function);
            }
        }
    }

    /// A range of successive points in the order of numbers(). In this order, the points of a cell are successive.
    struct Run {
        std::uint32_t begin, end;
    };

    /// Finds the points that for_near() visits, as runs.
    /// @param runs  out; cleared first
    void find_near(Point p, double reach, std::vector<Run>& runs) const;

    /// Returns the indices of all points in `places`, sorted by cell. Runs are ranges of this list.
    std::vector<std::uint32_t> numbers() const;

private:
    struct Axis {
        double origin = 0;
        double cells_per_length = 0;
        int cells = 0;

        double place(double v) const { return (v - origin) * cells_per_length; }
        int cell(double v) const { return static_cast<int>(std::clamp(place(v), 0.0, cells - 1.0)); }
    };

    struct Grid {
        Axis x, y;
        std::size_t first;  ///< index of the grid's first cell in cells_

        std::size_t cell(int column, int row) const {
            return first + static_cast<std::size_t>(row) * static_cast<std::size_t>(x.cells) +
                   static_cast<std::size_t>(column);
        }
        std::size_t cell(Point p) const { return cell(x.cell(p.x), y.cell(p.y)); }
    };

    struct Cell {
        std::uint32_t begin;     ///< index of the cell's first point in sorted_; the next cell's `begin` is the end
        std::uint32_t grid = 0;  ///< number of the cell's nested grid; 0 if none
    };

    struct Listed {
        Point place;
        std::uint32_t number;
    };

    struct Range {
        int first, last;
    };

    static int wrapped(int i, int cells) { return i < 0 ? i + cells : i >= cells ? i - cells : i; }

    /// Returns the range of cells of the first grid within `reach` of a coordinate. On a torus, the range may extend
    /// beyond the grid's ends, but contains no cell twice.
    Range around(double v, double reach, const Axis& axis) const {
        if (!torus_) return {axis.cell(v - reach), axis.cell(v + reach)};
        const auto cell = [&](double place) {
            return static_cast<int>(std::clamp(std::floor(axis.place(place)), -1.0 * axis.cells, 2.0 * axis.cells - 1));
        };
        const int first = cell(v - reach);
        return {first, std::min(cell(v + reach), first + axis.cells - 1)};
    }

    template <class Function>
    void look_into(std::size_t number, Point p, double reach, Point shift, Function& function) const {
        const Cell& cell = cells_[number];
        if (cell.grid == 0) {
            for (std::uint32_t k = cell.begin; k < cells_[number + 1].begin; ++k)
                function(sorted_[k].place + shift, sorted_[k].number);
            return;
        }
        const Grid& grid = grids_[cell.grid];
        const Point q = p - shift;
        for (int j = grid.y.cell(q.y - reach); j <= grid.y.cell(q.y + reach); ++j) {
            for (int i = grid.x.cell(q.x - reach); i <= grid.x.cell(q.x + reach); ++i)
                look_into(grid.cell(i, j), p, reach, shift, function);
        }
    }

    /// Appends to `runs` the points near p in some cells of one row, including the cells of nested grids.
    void add_row(const Grid& grid, int row, Range columns, Point p, double reach, std::vector<Run>& runs) const;

    void divide(const Box& box, std::uint32_t begin, std::uint32_t end, int depth);

    bool torus_;
    Point sides_;
    std::vector<Grid> grids_;     ///< the first one covers the domain
    std::vector<Cell> cells_;     ///< cells of each grid, each followed by a cell that marks the end
    std::vector<Listed> sorted_;  ///< sorted by cell
};

}  // namespace ccdt

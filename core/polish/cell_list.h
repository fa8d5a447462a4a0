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

/// Finds places near another one: a grid of about one place a cell, where cells that many places crowd into have a
/// grid of their own.
class CellList {
public:
    /// @param places  [n >= 1], in the domain's box; on a torus within it
    /// O(places), times the depth of grids in grids.
    CellList(const Domain& domain, std::span<const Point> places);

    /// Calls function(place, number) with each place that may be nearer than the reach, on a torus with its copy there.
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

    /// Places that follow each other in the list.
    struct Run {
        std::uint32_t begin, end;
    };

    /// Finds the places that for_near() calls with, as runs. @param runs  cleared before
    void find_near(Point p, double reach, std::vector<Run>& runs) const;

    /// Numbers of the places, as they are listed.
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
        std::size_t first;  ///< of its cells in cells_

        std::size_t cell(int column, int row) const {
            return first + static_cast<std::size_t>(row) * static_cast<std::size_t>(x.cells) +
                   static_cast<std::size_t>(column);
        }
        std::size_t cell(Point p) const { return cell(x.cell(p.x), y.cell(p.y)); }
    };

    struct Cell {
        std::uint32_t begin;     ///< of its places in sorted_; the next cell's ends them
        std::uint32_t grid = 0;  ///< of its own; 0: none
    };

    struct Listed {
        Point place;
        std::uint32_t number;
    };

    struct Range {
        int first, last;
    };

    static int wrapped(int i, int cells) { return i < 0 ? i + cells : i >= cells ? i - cells : i; }

    /// Cells of the first grid; on a torus beyond its ends, too, but none twice.
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

    /// Adds the places of a row's cells.
    void add_row(const Grid& grid, int row, Range columns, Point p, double reach, std::vector<Run>& runs) const;

    void divide(const Box& box, std::uint32_t begin, std::uint32_t end, int depth);

    bool torus_;
    Point sides_;
    std::vector<Grid> grids_;     ///< the first one is that of the domain
    std::vector<Cell> cells_;     ///< of each grid, and one that ends them
    std::vector<Listed> sorted_;  ///< by cells
};

}  // namespace ccdt

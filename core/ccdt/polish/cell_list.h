// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/elementary.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Returns the side of squares of which about `count` cover a rectangle.
inline double cell_side(Point sides, double count) {
    return std::sqrt(sides.x * sides.y / count);
}

/// Returns the side of cubes of which about `count` cover a box. A flat box has a single layer of cubes.
inline double cell_side(Point3 sides, double count) {
    const double face = std::max({sides.x * sides.y, sides.y * sides.z, sides.z * sides.x});
    return std::max(elementary::cbrt(sides.x * sides.y * sides.z / count), std::sqrt(face / count));
}

/// Finds the points near a position by means of a grid with about one cell per point. Each crowded cell has a nested
/// grid.
/// @tparam P  Point or Point3
template <class P>
class BasicCellList {
public:
    /// @param positions  [n >= 1], in the domain's bounding box; on a torus, wrapped into it
    ///
    /// O(points), multiplied by the depth of nested grids.
    BasicCellList(const Domain& domain, std::span<const P> positions);

    /// @param positions  [n >= 1], anywhere in space
    ///
    /// O(points), multiplied by the depth of nested grids, which is small even for points on a surface.
    explicit BasicCellList(std::span<const P> positions);

    /// @param torus      sides of a torus in space, > 0
    /// @param positions  [n >= 1], wrapped into the torus
    BasicCellList(P torus, std::span<const P> positions);

    /// Calls function(point, number) for each point that may be within `reach` of p. Some points farther away may be
    /// included. `number` is the index of the point in `positions`. On a torus, `point` is the copy nearest to p.
    /// @param reach     > 0
    /// @param function  may return a bool; the search ends when it is false
    template <class Function>
    void for_near(P p, double reach, Function&& function) const {
        const Grid& grid = grids_.front();
        const Range x = around(p.x, reach, grid.x), y = around(p.y, reach, grid.y);
        const Range z = around(height(p), reach, grid.z);
        for (int k = z.first; k <= z.last; ++k) {
            const int layer = wrapped(k, grid.z.cells);
            for (int j = y.first; j <= y.last; ++j) {
                for (int i = x.first; i <= x.last; ++i) {
                    const int column = wrapped(i, grid.x.cells), row = wrapped(j, grid.y.cells);
                    const P shift = vector((i - column) / grid.x.cells * sides_.x, (j - row) / grid.y.cells * sides_.y,
                                           (k - layer) / grid.z.cells * height(sides_));
                    if (!look_into(grid.cell(column, row, layer), p, reach, shift, function)) return;
                }
            }
        }
    }

    /// A range of successive points in the order of numbers(). In this order, the points of a cell are successive.
    struct Run {
        std::uint32_t begin, end;
    };

    /// Finds the points that for_near() visits, as runs.
    /// @param runs  out; cleared first
    void find_near(P p, double reach, std::vector<Run>& runs) const;

    /// Returns the indices of all points in `positions`, sorted by cell. Runs are ranges of this list.
    std::vector<std::uint32_t> numbers() const;

private:
    static constexpr bool kInSpace = std::same_as<P, Point3>;

    static double height(P p) {
        if constexpr (kInSpace) return p.z;
        return 0;
    }
    static P vector(double x, double y, double z) {
        if constexpr (kInSpace)
            return {x, y, z};
        else
            return {x, y};
    }

    struct Range {
        int first, last;
    };

    struct Axis {
        double origin = 0;
        double cells_per_length = 0;
        int cells = 1;

        double position(double v) const { return (v - origin) * cells_per_length; }
        int cell(double v) const { return static_cast<int>(std::clamp(position(v), 0.0, cells - 1.0)); }
        Range within(double v, double reach) const { return {cell(v - reach), cell(v + reach)}; }
    };

    /// Cells in rows along x. In the plane, there is one layer of cells.
    struct Grid {
        Axis x, y, z;
        std::size_t first;  ///< index of the grid's first cell in cells_

        std::size_t cell(int column, int row, int layer) const {
            const auto rows = static_cast<std::size_t>(layer) * static_cast<std::size_t>(y.cells);
            return first + (rows + static_cast<std::size_t>(row)) * static_cast<std::size_t>(x.cells) +
                   static_cast<std::size_t>(column);
        }
        std::size_t cell(P p) const { return cell(x.cell(p.x), y.cell(p.y), layers(p, 0).first); }
        Range layers(P p, double reach) const {
            if constexpr (kInSpace) return z.within(p.z, reach);
            return {0, 0};
        }
    };

    struct Cell {
        std::uint32_t begin;     ///< index of the cell's first point in sorted_; the next cell's `begin` is the end
        std::uint32_t grid = 0;  ///< number of the cell's nested grid; 0 if none
    };

    struct Listed {
        P position;
        std::uint32_t number;
    };

    static int wrapped(int i, int cells) { return i < 0 ? i + cells : i >= cells ? i - cells : i; }

    /// Returns the range of cells of the first grid within `reach` of a coordinate. On a torus, the range may extend
    /// beyond the grid's ends, but contains no cell twice.
    Range around(double v, double reach, const Axis& axis) const {
        if (!torus_) return axis.within(v, reach);
        const auto cell = [&](double position) {
            return static_cast<int>(
                std::clamp(std::floor(axis.position(position)), -1.0 * axis.cells, 2.0 * axis.cells - 1));
        };
        const int first = cell(v - reach);
        return {first, std::min(cell(v + reach), first + axis.cells - 1)};
    }

    /// @returns  false if the function has returned false
    template <class Function>
    bool look_into(std::size_t number, P p, double reach, P shift, Function& function) const {
        const Cell& cell = cells_[number];
        if (cell.grid == 0) {
            for (std::uint32_t k = cell.begin; k < cells_[number + 1].begin; ++k) {
                if constexpr (std::same_as<bool, decltype(function(p, k))>) {
                    if (!function(sorted_[k].position + shift, sorted_[k].number)) return false;
                } else {
                    function(sorted_[k].position + shift, sorted_[k].number);
                }
            }
            return true;
        }
        const Grid& grid = grids_[cell.grid];
        const P q = p - shift;
        const Range x = grid.x.within(q.x, reach), y = grid.y.within(q.y, reach), z = grid.layers(q, reach);
        for (int k = z.first; k <= z.last; ++k) {
            for (int j = y.first; j <= y.last; ++j) {
                for (int i = x.first; i <= x.last; ++i) {
                    if (!look_into(grid.cell(i, j, k), p, reach, shift, function)) return false;
                }
            }
        }
        return true;
    }

    /// Appends to `runs` the points near p in some cells of one row, including the cells of nested grids.
    /// @param row  index of the row's first cell
    void add_row(std::size_t row, Range columns, P p, double reach, std::vector<Run>& runs) const;

    /// Lists points and sorts them into grids.
    void sort(std::span<const P> positions, P min, P max);

    /// Sorts points into the cells of a grid over a box, and recurses into crowded cells.
    void divide(P min, P max, std::uint32_t begin, std::uint32_t end, int depth);

    bool torus_;
    P sides_;                     ///< sides of a torus
    std::vector<Grid> grids_;     ///< the first one covers the domain
    std::vector<Cell> cells_;     ///< cells of each grid, each followed by a cell that marks the end
    std::vector<Listed> sorted_;  ///< sorted by cell
};

// The first constructor exists only in the plane, the others only in space.
template <>
BasicCellList<Point>::BasicCellList(const Domain& domain, std::span<const Point> positions);
template <>
BasicCellList<Point3>::BasicCellList(std::span<const Point3> positions);
template <>
BasicCellList<Point3>::BasicCellList(Point3 torus, std::span<const Point3> positions);

extern template class BasicCellList<Point>;
extern template class BasicCellList<Point3>;

using CellList = BasicCellList<Point>;
using CellList3 = BasicCellList<Point3>;

}  // namespace ccdt

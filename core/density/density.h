// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A block of a grid's cells: columns [left, right), rows [low, high).
struct CellBlock {
    int left = 0;
    int low = 0;
    int right = 0;
    int high = 0;

    int columns() const { return right - left; }
    int rows() const { return high - low; }
};

/// The wanted density of sites, relative to other places: constant, or constant on each cell of a grid that is
/// stretched over the bounding box of the domain.
///
/// Only ratios matter. At creation, all values are scaled by one power of two, which loses no precision: the largest
/// value then lies in [1, 2), and values below kMin count as 0. So all of the following are finite and do not
/// underflow: sums of values, products of two values, products of a value and an area, and quotients of these.
/// Densities that differ by a power of two give identical bytes.
class Density {
public:
    /// The least positive value. This value is so small that it affects no number of sites.
    static constexpr double kMin = 0x1p-256;

    static Density uniform() { return {}; }

    /// @param values  [width * height], row by row, the first row at the smallest y; finite, >= 0, at least one > 0
    ///
    /// Errors: Malformed for a wrong number of values or a value out of range (`values/i`); Unusable if all are zero.
    static Result<Density> grid(int width, int height, std::span<const double> values);
    static Result<Density> grid(int width, int height, std::span<const float> values);

    /// Declares that the density hardly varies between neighbouring sites. The pattern is then treated as uniform.
    Density smooth() && {
        is_smooth_ = true;
        return std::move(*this);
    }

    bool is_uniform() const { return width_ == 0; }
    bool is_smooth() const { return is_uniform() || is_smooth_; }
    int width() const { return width_; }    ///< cells; 0 if uniform
    int height() const { return height_; }  ///< cells; 0 if uniform

    /// Returns the scaled value of a cell, with the rounding errors of the row's prefix sums. This function and all
    /// those below must not be called for a uniform density.
    double value(int column, int row) const {
        const double* sums = row_sums_.data() + static_cast<std::size_t>(row) * (static_cast<std::size_t>(width_) + 1) +
                             static_cast<std::size_t>(column);
        return sums[1] - sums[0];
    }

    /// Returns the prefix sums of a row: `row_sums(row)[x]` is the sum of the values left of column x, x in [0, width].
    std::span<const double> row_sums(int row) const;

    /// Returns the block of all cells.
    CellBlock cells() const { return {0, 0, width_, height_}; }

    /// Returns the smallest block that contains all nonzero cells. O(cells).
    CellBlock support() const;

    /// Integrates the density over each cell in one row of another grid, which has `columns` x `rows` cells and is
    /// stretched over a block of this grid. Areas are in units of this grid's cells.
    /// @param masses  out, [columns]
    void resample_row(const CellBlock& block, int columns, int rows, int row, std::span<double> masses) const;

    /// Returns the sum of all values.
    double total() const { return total_; }

    /// Returns the largest value, in [1, 2).
    double largest() const { return largest_; }

private:
    template <class T>
    static Result<Density> make(int width, int height, std::span<const T> values);

    int width_ = 0;
    int height_ = 0;
    double total_ = 0;
    double largest_ = 0;
    bool is_smooth_ = false;
    std::vector<double> row_sums_;  ///< [height][width + 1] prefix sums of each row
};

}  // namespace ccdt

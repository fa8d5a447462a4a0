#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/result.h"

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

/// Density of sites that areas want, relative to other areas: constant, or constant on each cell of a grid that is
/// stretched over the bounding box of the domain.
///
/// Only ratios matter, so that values are scaled where they enter, all by one power of two, which costs no digit:
/// the largest lies in [1, 2), and what is below kLeast counts as 0. Whoever computes with values may rely on it:
/// their sums, products of two of them and of areas with these, and the quotients of such are finite, and none of
/// them is lost to underflow. Densities whose values differ by a power of two are the same, byte for byte.
class Density {
public:
    /// The least value but 0: far less than what any number of sites takes notice of.
    static constexpr double kLeast = 0x1p-256;

    static Density uniform() { return {}; }

    /// @param values  [width * height], row by row, the first row at the smallest y; finite, >= 0, one > 0
    /// Errors: Malformed for a wrong count or value (field `values/i`), Unusable if all are zero.
    static Result<Density> grid(int width, int height, std::span<const double> values);
    static Result<Density> grid(int width, int height, std::span<const float> values);

    /// The same density, told to change so little from one site to the next that the pattern shall be that of a uniform
    /// one.
    Density smooth() && {
        is_smooth_ = true;
        return std::move(*this);
    }

    bool is_uniform() const { return width_ == 0; }
    bool is_smooth() const { return is_uniform() || is_smooth_; }
    int width() const { return width_; }    ///< cells; 0 if uniform
    int height() const { return height_; }  ///< cells; 0 if uniform

    /// Value of a cell, as scaled, to the rounding of its row's sums.
    double value(int column, int row) const {
        const double* sums = row_sums_.data() + static_cast<std::size_t>(row) * (static_cast<std::size_t>(width_) + 1) +
                             static_cast<std::size_t>(column);
        return sums[1] - sums[0];
    }

    /// Sum of the values in a row left of column x; `row_sums(row)[x]`, x in [0, width].
    std::span<const double> row_sums(int row) const;

    /// Block of all cells. Not for uniform densities, nor are the following.
    CellBlock cells() const { return {0, 0, width_, height_}; }

    /// The smallest block with all that is not zero. O(cells).
    CellBlock support() const;

    /// Integral over each cell of one row of another grid, of `columns` x `rows` cells over a block of this one, in
    /// units of this grid's cells [columns].
    void resample_row(const CellBlock& block, int columns, int rows, int row, std::span<double> masses) const;

    /// Sum of all values.
    double total() const { return total_; }

    /// Largest value: in [1, 2).
    double largest() const { return largest_; }

private:
    template <class T>
    static Result<Density> make(int width, int height, std::span<const T> values);

    int width_ = 0;
    int height_ = 0;
    double total_ = 0;
    double largest_ = 0;
    bool is_smooth_ = false;
    std::vector<double> row_sums_;  ///< [height][width + 1]
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <span>
#include <variant>
#include <vector>

#include "core/fourier/fft.h"
#include "core/geometry/pair.h"
#include "core/geometry/point.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// A grid over a box or torus, and its transform. On a torus, this is the Fourier transform. In a box, it is the cosine
/// transform, which corresponds to a grid that is mirrored at its sides. Points are spread onto the grid, and values
/// are read from it, with quintic B-splines. Spreading and transforming, followed by a division by the spectrum of the
/// splines, window(), is a non-uniform transform. For frequencies up to a fifth of a cycle per cell, the error
/// consists of aliases of higher frequencies, each with less than 3e-4 of the original amplitude.
///
/// Source: Beylkin, On the fast Fourier transform of functions with singularities, 1995.
class SplineGrid {
public:
    /// @param sides          size of the box, > 0
    /// @param columns, rows  even, >= 2; see good_size()
    /// @param executor       runs operations on the whole grid and on many points; must outlive this object
    SplineGrid(bool torus, Point sides, int columns, int rows, Executor& executor = inline_executor());

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    Point cell() const { return {sides_.x / columns_, sides_.y / rows_}; }

    /// Releases the memory. The next call must be clear(), which allocates the memory again.
    void release_memory();
    /// Sets all values to 0. Must be called before the first spread().
    void clear();
    /// Adds a point with a value.
    /// @param p  inside the box; on a torus, any periodic copy
    void spread(Point p, double value);
    /// Adds the change of the grid values, to first order, if a spread point with value 1 moves from `p` by `move`.
    /// This is the transpose of gradient(), apart from the factor window().
    void spread_move(Point p, Point move);
    /// Adds many points, as spread() does for each point with a value other than 0.
    /// @param values  [points]; empty: 1 each
    void spread(std::span<const Point> points, std::span<const double> values);
    /// Adds the changes of many moves, as spread_move() does for each.
    void spread_moves(std::span<const Point> points, std::span<const Point> moves);
    /// Computes the coefficients of the spread values.
    void transform();

    /// Transforms coefficients to the values that gradient() reads.
    void transform_back();
    /// Returns the gradient, per unit of length, of the function whose coefficients transform_back() has transformed.
    /// The coefficients must have been divided by window() before.
    Point gradient(Point p) const;
    /// Computes the gradients at many points. Faster than separate calls.
    /// @param gradients  out [points]; may be the memory of `points`
    void gradients(std::span<const Point> points, std::span<Point> gradients) const;

    /// Returns the values of the cells [rows * columns], for transforms without splines. forward() transforms these
    /// values to coefficients, and backward() transforms back. Both together multiply the values by cells().
    std::span<double> grid();
    void forward();
    void backward();
    double cells() const { return copies() * columns_ * rows_; }

    /// Calls visit(coefficients) with a span of double (box) or std::complex<double> (torus); order: for_frequencies().
    template <class Visit>
    void with_coefficients(Visit&& visit) {
        if (auto* fourier = std::get_if<RealTransform>(&transform_)) {
            visit(fourier->spectrum());
        } else {
            visit(std::get<CosineTransform>(transform_).grid());
        }
    }

    /// Calls visit(number of the coefficient, column, row) for all frequencies, some calls in parallel. Rows may be
    /// negative. Skips aliased frequencies.
    template <class Visit>
    void for_frequencies(Visit&& visit) const {
        for_ranges(executor_, static_cast<std::size_t>(rows_), kRows, [&](std::size_t begin, std::size_t end) {
            std::size_t number = begin * static_cast<std::size_t>(kept_);
            for (auto row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
                const int j = signed_row(row);
                for (int i = 0; i < kept_; ++i, ++number) {
                    if (!torus_ || (2 * i != columns_ && 2 * row != rows_)) visit(number, i, j);
                }
            }
        });
    }

    /// Row as for_frequencies() passes it: negative for the upper half of the rows on a torus.
    int signed_row(int row) const { return torus_ && 2 * row > rows_ ? row - rows_ : row; }

    std::size_t coefficient_count() const { return static_cast<std::size_t>(kept_) * static_cast<std::size_t>(rows_); }
    std::size_t number(int column, int row) const {
        return static_cast<std::size_t>(row < 0 ? row + rows_ : row) * static_cast<std::size_t>(kept_) +
               static_cast<std::size_t>(column);
    }

    /// Frequency in cycles per unit of length.
    Point frequency(int column, int row) const {
        const double waves = torus_ ? 1 : 0.5;
        return {waves * column / sides_.x, waves * row / sides_.y};
    }

    /// Factor by which spreading multiplies a coefficient.
    double window(int column, int row) const {
        return column_windows_[static_cast<std::size_t>(column)] *
               row_windows_[static_cast<std::size_t>(std::abs(row))];
    }

    /// Ratio of a coefficient to the integral that it represents.
    double copies() const { return torus_ ? 1 : 4; }

private:
    /// Positions of points in the padded grid. A point has taps in six columns and six rows, three on each side of the
    /// point. `fractions` is the offset of each point, in cells, from the third column and the third row.
    template <class Lanes>
    struct Places {
        std::array<std::size_t, Lanes::kCount> rows;   ///< first row of the taps
        std::array<std::size_t, Lanes::kCount> first;  ///< index of the first tap
        typename Lanes::Pairs fractions;
    };
    template <class Lanes>
    Places<Lanes> places(const std::array<Point, Lanes::kCount>& points) const;
    template <class Lanes>
    void spread_few(const std::array<Point, Lanes::kCount>& points, const std::array<double, Lanes::kCount>& values);
    template <class Lanes>
    std::array<Point, Lanes::kCount> gradients_of(const std::array<Point, Lanes::kCount>& points) const;
    std::size_t padded_size() const;
    void acquire_memory();
    void fold();
    void unfold();
    double* padded_row(std::size_t number) { return &padded_[number * stride_]; }
    template <class Visit>
    void for_margins(Visit&& visit) const;
    template <class Visit>
    void for_margin_rows(Visit&& visit);
    template <class Counts, class Add>
    void add_all(std::span<const Point> points, Counts&& counts, Add&& add);
    std::size_t folded(std::size_t padded, int cells) const;

    static constexpr std::size_t kRows = 16;  ///< rows per task; more than the taps reach

    Executor& executor_;
    bool torus_;
    Point sides_;
    int columns_;
    int rows_;
    int kept_;            ///< number of columns of coefficients
    Pair half_cell_;      ///< half a cell relative to the box's sides
    std::size_t stride_;  ///< number of values in a row of the padded grid
    std::vector<double> column_windows_, row_windows_;
    std::variant<RealTransform, CosineTransform> transform_;
    /// The grid with its margin for taps, in the memory of the spectrum (torus) or of the grid (box).
    std::span<double> padded_;
};

}  // namespace ccdt

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
#include "core/parallel/team.h"

namespace ccdt {

/// A grid over a box or a torus that points are spread on and read from with quintic B-splines, and its transform:
/// Fourier's on a torus, the cosine one in a box, as if mirrored at its sides. Together a non-uniform transform: the
/// splines' own spectrum, window(), divides out; for frequencies up to a fifth of a cycle a cell its error is below
/// 3e-4 of what lies beyond.
/// Source: Beylkin, On the fast Fourier transform of functions with singularities, 1995.
class SplineGrid {
public:
    /// @param sides          of the box, > 0
    /// @param columns, rows  even, >= 2; see good_size()
    /// @param team           does what is done on all of the grid, and with many points; must outlive this
    SplineGrid(bool torus, Point sides, int columns, int rows, Team& team = alone());

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    Point cell() const { return {sides_.x / columns_, sides_.y / rows_}; }

    /// Gives the memory back. The next clear() brings it again; nothing else may come before.
    void rest();
    /// Sets all values to 0; to be called before the first spread().
    void clear();
    /// Adds a point of this value.
    /// @param p  inside the box; on a torus anywhere
    void spread(Point p, double value);
    /// Adds the change of what a point of value 1 spreads, as it moves by a vector that is as small as may be: the
    /// transpose of gradient(), but for what is told of window().
    void spread_move(Point p, Point move);
    /// Adds many points: spread() of each whose value is not 0.
    /// @param values  [points]; empty: 1 each
    void spread(std::span<const Point> points, std::span<const double> values);
    /// The same with spread_move().
    void spread_moves(std::span<const Point> points, std::span<const Point> moves);
    /// Computes the coefficients of what was spread.
    void transform();

    /// Computes from coefficients the values that gradient() reads.
    void transform_back();
    /// Gradient of the function whose coefficients were those over window(), in its units per unit of length.
    Point gradient(Point p) const;
    /// The same at many points, in less time than each by itself.
    /// @param gradients  out [points]; may be where the points are
    void gradients(std::span<const Point> points, std::span<Point> gradients) const;

    /// Values of the cells [rows * columns], for plain transforms: forward() and backward(), which multiply by cells()
    /// together.
    std::span<double> grid();
    void forward();
    void backward();
    double cells() const { return copies() * columns_ * rows_; }

    /// Calls visit(coefficients), a span of double in a box and of std::complex<double> on a torus, numbered as by
    /// for_frequencies().
    template <class Visit>
    void with_coefficients(Visit&& visit) {
        if (auto* fourier = std::get_if<RealTransform>(&transform_)) {
            visit(fourier->spectrum());
        } else {
            visit(std::get<CosineTransform>(transform_).grid());
        }
    }

    /// Calls visit(number of the coefficient, column, row) for all, several at the same time; rows may be negative.
    /// Those that alias are left out.
    template <class Visit>
    void for_frequencies(Visit&& visit) const {
        for_ranges(team_, static_cast<std::size_t>(rows_), kRows, [&](std::size_t begin, std::size_t end) {
            std::size_t number = begin * static_cast<std::size_t>(kept_);
            for (auto row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
                const int j = signed_row(row);
                for (int i = 0; i < kept_; ++i, ++number) {
                    if (!torus_ || (2 * i != columns_ && 2 * row != rows_)) visit(number, i, j);
                }
            }
        });
    }

    /// Row as for_frequencies() tells it.
    int signed_row(int row) const { return torus_ && 2 * row > rows_ ? row - rows_ : row; }

    std::size_t coefficient_count() const { return static_cast<std::size_t>(kept_) * static_cast<std::size_t>(rows_); }
    std::size_t number(int column, int row) const {
        return static_cast<std::size_t>(row < 0 ? row + rows_ : row) * static_cast<std::size_t>(kept_) +
               static_cast<std::size_t>(column);
    }

    /// Cycles per unit of length.
    Point frequency(int column, int row) const {
        const double waves = torus_ ? 1 : 0.5;
        return {waves * column / sides_.x, waves * row / sides_.y};
    }

    /// Factor by which spreading multiplies a coefficient.
    double window(int column, int row) const {
        return column_windows_[static_cast<std::size_t>(column)] *
               row_windows_[static_cast<std::size_t>(std::abs(row))];
    }

    /// A coefficient over the integral that it stands for.
    double copies() const { return torus_ ? 1 : 4; }

private:
    /// Of each point the padded grid point three columns and rows before it, and how far behind the third one it lies.
    template <class Lanes>
    struct Places {
        std::array<std::size_t, Lanes::kCount> first;
        typename Lanes::Pairs fractions;
    };
    double along(double coordinate, double side, int cells) const;
    static double point_before(double place, int cells);
    template <class Lanes>
    Places<Lanes> places(const std::array<Point, Lanes::kCount>& points) const;
    template <class Lanes>
    void spread_few(const std::array<Point, Lanes::kCount>& points, const std::array<double, Lanes::kCount>& values);
    void spread_two(const std::array<Point, 2>& points, const std::array<double, 2>& values);
    template <class Lanes>
    std::array<Point, Lanes::kCount> gradients_of(const std::array<Point, Lanes::kCount>& points) const;
    std::array<Point, 2> two_gradients(const std::array<Point, 2>& points) const;
    std::size_t first_row(Point p) const;
    std::size_t padded_size() const;
    void take_room();
    void fold();
    void unfold();
    void close_up();
    void open_up();
    double* padded_row(std::size_t number) { return &padded_[number * stride_]; }
    template <class Visit>
    void for_margins(Visit&& visit) const;
    template <class Visit>
    void for_margin_rows(Visit&& visit);
    template <class Visit>
    void for_padded(std::size_t number, Visit&& visit);
    template <class Counts, class Add>
    void add_all(std::span<const Point> points, Counts&& counts, Add&& add);
    std::size_t folded(std::size_t padded, int cells) const;

    static constexpr std::size_t kRows = 16;  ///< that a task takes; more than taps reach

    Team& team_;
    bool torus_;
    Point sides_;
    int columns_;
    int rows_;
    int kept_;        ///< columns of coefficients
    Pair half_cell_;  ///< over the box's sides
    std::size_t stride_;
    std::vector<double> column_windows_, row_windows_;
    std::variant<RealTransform, CosineTransform> transform_;
    /// The grid, and around it the room that taps reach; on a torus the spectrum's memory, in a box the grid's own.
    std::span<double> padded_;
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/fourier/fft.h"
#include "core/geometry/point.h"

namespace ccdt {

struct WeightedPoint {
    Point position;  ///< in [0, 1] x [0, 1]
    double weight = 1;
};

/// Fourier sums over points at arbitrary positions, F(i, j) = sum_p weight_p e^(-2 pi i (i x_p + j y_p)), for integers
/// |i| <= highest_x, |j| <= highest_y. Each point is spread over 12 x 12 cells of a grid with twice the required
/// resolution. The grid is transformed, and the effect of the spreading is divided out.
///
/// The error of each F is below 1e-10 times the sum of |weights|. For n points of weight 1 without structure, the error
/// is below 1e-9 sqrt(n). O(n + N log N) for N = cells(), 16 bytes per cell.
///
/// Source: Barnett, Magland, af Klinteberg 2019, with the "exponential of semicircle" kernel; upsampling factor 2.
class NonuniformTransform {
public:
    /// Returns the number of cells of the grid for the given highest frequencies.
    static double cells(double highest_x, double highest_y);

    /// @param highest_x, highest_y  >= 0
    NonuniformTransform(int highest_x, int highest_y);

    /// Computes all F. A stop ends the computation early; the values must not be used then.
    void run(std::span<const WeightedPoint> points, const std::stop_token& stop);

    /// Returns F(i, j) of the last run, 0 <= i <= highest_x, |j| <= highest_y.
    std::complex<double> value(int i, int j) const;

private:
    friend class ShiftedTransform;

    /// Returns the factor that undoes the effect of the spreading on F(i, j).
    double factor(int i, int j) const;
    /// Returns F(i, j) as transformed, before factor() is applied, for i of either sign.
    std::complex<double> coefficient(int i, int j) const;

    int columns_;
    int rows_;
    std::vector<double> unspread_x_;  ///< [|i|] factors that undo the spreading
    std::vector<double> unspread_y_;  ///< [|j|] factors that undo the spreading
    RealTransform transform_;
};

/// Fourier sums in a range around a central frequency. The grid only has to resolve this range, so it is smaller than
/// the grid of NonuniformTransform. Each point's weight is multiplied by the complex wave of the central frequency at
/// the point. The real and the imaginary parts of these products are spread on separate grids.
///
/// Errors as in NonuniformTransform. O(n + N log N) for N cells of 32 bytes.
class ShiftedTransform {
public:
    /// Returns the number of cells of each of the two grids.
    static double cells(double reach_x, double reach_y) { return NonuniformTransform::cells(reach_x, reach_y); }

    /// @param reach_x, reach_y  >= 0
    ShiftedTransform(int reach_x, int reach_y) : real_(reach_x, reach_y), imaginary_(reach_x, reach_y) {}

    /// Computes F around (middle_x, middle_y). A stop ends the computation early; the values must not be used then.
    /// @param points  run() is several times faster if successive points are near each other
    void run(std::span<const WeightedPoint> points, int middle_x, int middle_y, const std::stop_token& stop);

    /// Returns F(middle_x + i, middle_y + j) of the last run, |i| <= reach_x, |j| <= reach_y.
    std::complex<double> value(int i, int j) const;

private:
    NonuniformTransform real_;
    NonuniformTransform imaginary_;
};

}  // namespace ccdt

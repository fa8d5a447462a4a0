// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/fft.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// @tparam P  Point or Point3
template <class P>
struct BasicWeightedPoint {
    P position;  ///< coordinates in [0, 1]
    double weight = 1;
};
using WeightedPoint = BasicWeightedPoint<Point>;

/// Fourier sums over points at arbitrary positions, F(i, j, k) = sum_p weight_p e^(-2 pi i (i x_p + j y_p + k z_p)),
/// for integers |i|, |j| and |k| up to the highest ones. In the plane, k = 0. Each point is spread over 12 cells along
/// each axis of a grid with twice the required resolution. The grid is transformed, and the effect of the spreading is
/// divided out.
///
/// The error of each F is below 1e-10 times the sum of |weights|. For n points of weight 1 without structure, the error
/// is below 1e-9 sqrt(n). O(n + N log N) for N = cells(), 16 bytes per cell.
///
/// Source: Barnett, Magland, af Klinteberg 2019, with the "exponential of semicircle" kernel; upsampling factor 2.
class NonuniformTransform {
public:
    /// Returns the number of cells of the grid for the given highest frequencies.
    static double cells(double highest_x, double highest_y, double highest_z = 0);

    /// @param highest_x, highest_y, highest_z  >= 0; if highest_z is 0, the grid has a single layer
    NonuniformTransform(int highest_x, int highest_y, int highest_z = 0);

    /// Computes all F. A stop ends the computation early; the values must not be used then.
    template <class P>
    void run(const std::vector<BasicWeightedPoint<P>>& points, const std::stop_token& stop);

    /// Returns F(i, j, k) of the last run, 0 <= i <= highest_x, |j| <= highest_y, |k| <= highest_z.
    std::complex<double> value(int i, int j, int k = 0) const;

private:
    friend class ShiftedTransform;

    /// Returns the factor that undoes the effect of the spreading on F(i, j, k).
    double factor(int i, int j, int k) const;
    /// Returns F(i, j, k) as transformed, before factor() is applied, for i of either sign.
    std::complex<double> coefficient(int i, int j, int k) const;

    std::array<int, 3> cells_;                     ///< columns, rows, layers
    std::array<std::vector<double>, 3> unspread_;  ///< [axis][|i|] factors that undo the spreading
    RealTransform transform_;
};

/// Fourier sums in a range around a central frequency. The grid only has to resolve this range, so it is smaller than
/// the grid of NonuniformTransform. Each point's weight is multiplied by the complex wave of the central frequency at
/// the point. The real and the imaginary parts of these products are spread on separate grids.
///
/// Errors as in NonuniformTransform. O(n + N log N) for N cells of 32 bytes.
class ShiftedTransform {
public:
    /// @param reach_x, reach_y, reach_z  >= 0
    ShiftedTransform(int reach_x, int reach_y, int reach_z)
        : real_(reach_x, reach_y, reach_z), imaginary_(reach_x, reach_y, reach_z) {}

    /// Computes F around the middle [x, y, z]. A stop ends the computation early; the values must not be used then.
    /// @param points  run() is several times faster if successive points are near each other
    template <class P>
    void run(const std::vector<BasicWeightedPoint<P>>& points, const std::array<int, 3>& middle,
             const std::stop_token& stop);

    /// Returns F(middle + (i, j, k)) of the last run, |i| <= reach_x, |j| <= reach_y, |k| <= reach_z.
    std::complex<double> value(int i, int j, int k) const;

private:
    NonuniformTransform real_;
    NonuniformTransform imaginary_;
};

}  // namespace ccdt

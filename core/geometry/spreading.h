// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/base/elementary.h"
#include "core/base/pair.h"

// Spreads points on a grid, and reads values from the grid, with the product of a kernel along x and the same kernel
// along y. A tap is one of the grid points that the kernel covers.

namespace ccdt {

/// Returns the values of a B-spline at the grid points around a position. Their sum is 1.
/// @param f  offset of the position in its cell, in [0, 1] and in units of cells. For an odd degree, cells lie between
///           grid points. For degree 2, grid points are at the centres of cells.
template <int kDegree, class Number>
CCDT_INLINE inline std::array<Number, kDegree + 1> b_spline(Number f) {
    static_assert(kDegree == 2 || kDegree == 3 || kDegree == 5);
    if constexpr (kDegree == 2) {
        const Number g = 1 - f;
        return {g * g / 2, static_cast<Number>(0.5) + f * g, f * f / 2};
    } else if constexpr (kDegree == 3) {
        const auto inner = [](Number d) CCDT_INLINE { return 2.0 / 3 - d * d * (1 - d / 2); };  // at distance d
        const Number g = 1 - f;
        return {g * g * g / 6, inner(f), inner(g), f * f * f / 6};
    } else {
        const auto outer = [](Number d) CCDT_INLINE {  // at distance 2 + d
            const Number g = 1.0 - d, g2 = g * g;
            return g2 * g2 * g * (1.0 / 120);
        };
        const auto inner = [](Number d) CCDT_INLINE {  // at distance 1 + d
            const Number x = 1.0 + d;
            return 17.0 / 40 + x * (5.0 / 8 + x * (-7.0 / 4 + x * (5.0 / 4 + x * (-3.0 / 8 + x * (1.0 / 24)))));
        };
        const auto middle = [](Number d) CCDT_INLINE {  // at distance d
            const Number d2 = d * d;
            return 11.0 / 20 + d2 * (-0.5 + d2 * (0.25 - d * (1.0 / 12)));
        };
        const Number g = 1.0 - f;
        return {outer(f), inner(f), middle(f), middle(g), inner(g), outer(g)};
    }
}

/// Steepness of semicircle(), per cell of width; optimal for twice the resolution.
inline constexpr double kSteepness = 2.3;

/// Returns the "exponential of semicircle" at a distance of at most kWidth / 2 cells from its centre.
/// Source: Barnett, Magland, af Klinteberg 2019.
template <int kWidth>
double semicircle(double distance) {
    const double share = 2 * distance / kWidth;
    return elementary::exp(kSteepness * kWidth * (std::sqrt(std::max(0.0, 1 - share * share)) - 1));
}

/// Returns the Fourier transform of semicircle() at a frequency of `periods` per `cells` cells.
template <int kWidth>
double semicircle_spectrum(double periods, int cells) {
    // The error of the trapezoidal rule is the kernel's content at frequencies above 1 / kStep - 1/2 per cell, which is
    // negligible.
    constexpr int kSteps = 4 * kWidth / 2;
    constexpr double kStep = 0.25;
    double sum = semicircle<kWidth>(0) / 2;
    for (int s = 1; s < kSteps; ++s)
        sum += semicircle<kWidth>(s * kStep) * elementary::cos(2 * std::numbers::pi * periods * s * kStep / cells);
    return 2 * kStep * sum;
}

/// Returns sin(pi x) / (pi x), or 1 for x = 0: the Fourier transform of an interval of length 1 at the frequency x.
inline double sinc(double x) {
    const double angle = std::numbers::pi * x;
    return angle == 0 ? 1 : elementary::sin(angle) / angle;
}

/// Calls spread(row, column, factor * y[row] * x[column]) for all taps.
/// @param x, y  values of the kernel along x and y
template <class Number, std::size_t kTaps, class Spread>
inline void for_taps(const std::array<Number, kTaps>& x, const std::array<Number, kTaps>& y, Number factor,
                     Spread&& spread) {
    for (std::size_t row = 0; row < kTaps; ++row) {
        const Number share = factor * y[row];
        for (std::size_t column = 0; column < kTaps; ++column) spread(row, column, share * x[column]);
    }
}

/// Returns the sum over all taps of y[row] * x[column] * line(row)[column].
/// @param line  returns a pointer to the grid values at the taps of a row
template <class Number, std::size_t kTaps, class Line>
inline Number sum_taps(const std::array<Number, kTaps>& x, const std::array<Number, kTaps>& y, Line&& line) {
    Number sum = 0;
    for (std::size_t row = 0; row < kTaps; ++row) {
        const Number* const values = line(row);
        Number part = x[0] * values[0];
        for (std::size_t column = 1; column < kTaps; ++column) part += x[column] * values[column];
        sum += y[row] * part;
    }
    return sum;
}

}  // namespace ccdt

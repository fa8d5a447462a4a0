// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Implements the transforms of line_set.h for the instruction set for which the including file compiles pocketfft. No
// other file includes pocketfft.

// Debian 12 has no package of pocketfft. A copy of this header-only library is among the third-party headers in the
// package of gemmi, a library for crystallography. Nothing else of gemmi is used.
#define POCKETFFT_NO_MULTITHREADING
// pocketfft allocates with aligned_alloc(), and passes sizes that are not multiples of the alignment, which C forbids.
// The only way to make it use malloc() instead is this macro, although its name is reserved for libc++.
#define _LIBCPP_HAS_NO_ALIGNED_ALLOCATION  // NOLINT(bugprone-reserved-identifier)
#include <gemmi/third_party/pocketfft_hdronly.h>
#undef _LIBCPP_HAS_NO_ALIGNED_ALLOCATION

#include "core/base/elementary.h"
#include "core/base/line_set.h"

/// @cond
// Twiddle factors that do not depend on the C library: this replaces the only function of pocketfft that calls cos()
// and sin(). Returns the complex number of absolute value 1 whose angle is x / n of a full circle; angle = pi / (4 n).
template <>
inline pocketfft::detail::cmplx<double> pocketfft::detail::sincos_2pibyn<double>::calc(std::size_t x, std::size_t n,
                                                                                       double angle) {
    const bool is_below = 2 * x > n;
    if (is_below) x = n - x;
    x *= 8;
    // Of the eight octants, the first four are left.
    const std::size_t quarter = (x + n) / (2 * n);
    const bool is_before = x < 2 * n * quarter;
    const double rest = static_cast<double>(is_before ? 2 * n * quarter - x : x - 2 * n * quarter) * angle;
    const double cosine = ccdt::elementary::cos(rest);
    const double sine = is_before ? -ccdt::elementary::sin(rest) : ccdt::elementary::sin(rest);
    const double real = quarter == 0 ? cosine : quarter == 1 ? -sine : -cosine;
    const double imaginary = quarter == 0 ? sine : quarter == 1 ? cosine : -sine;
    return {real, is_below ? -imaginary : imaginary};
}
/// @endcond

namespace ccdt {
namespace {

constexpr std::size_t kAlong = 1;  ///< index of the axis along the lines

pocketfft::shape_t shape_of(const LineSet& lines) {
    return {lines.count, lines.size};
}

template <class Number>
pocketfft::stride_t strides(std::size_t apart, std::size_t step) {
    return {static_cast<std::ptrdiff_t>(apart * sizeof(Number)), static_cast<std::ptrdiff_t>(step * sizeof(Number))};
}

template <int kType>
void transform_cosine(const LineSet& lines, double* values) {
    const auto positions = strides<double>(lines.apart, lines.step);
    pocketfft::dct(shape_of(lines), positions, positions, {kAlong}, kType, values, values, 1.0, false);
}

void transform_real(const LineSet& lines, const double* values, std::size_t apart, std::complex<double>* coefficients) {
    pocketfft::r2c(shape_of(lines), strides<double>(lines.apart, lines.step), strides<std::complex<double>>(apart, 1),
                   kAlong, pocketfft::FORWARD, values, coefficients, 1.0);
}

void transform_real_back(const LineSet& lines, double* values, std::size_t apart,
                         const std::complex<double>* coefficients) {
    pocketfft::c2r(shape_of(lines), strides<std::complex<double>>(apart, 1), strides<double>(lines.apart, lines.step),
                   kAlong, pocketfft::BACKWARD, coefficients, values, 1.0);
}

template <bool kForward>
void transform_complex(const LineSet& lines, std::complex<double>* values) {
    const auto positions = strides<std::complex<double>>(lines.apart, lines.step);
    pocketfft::c2c(shape_of(lines), positions, positions, {kAlong}, kForward, values, values, 1.0);
}

constexpr LineTransforms kLineTransforms{
    .cosine = transform_cosine<2>,
    .cosine_back = transform_cosine<3>,
    .real = transform_real,
    .real_back = transform_real_back,
    .complex = transform_complex<true>,
    .complex_back = transform_complex<false>,
};

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>

namespace ccdt {

/// Lines of numbers at equal distances in memory. All distances are counted in numbers, not bytes.
struct LineSet {
    std::size_t size;   ///< numbers per line, >= 1
    std::size_t step;   ///< distance between successive numbers of a line
    std::size_t count;  ///< number of lines, >= 1
    std::size_t apart;  ///< distance between successive lines
};

/// Transforms of lines, several lines at once. The result of a line depends neither on the other lines nor on the
/// processor, bit for bit. Uses pocketfft (Reinecke 2019), which caches its tables for recent sizes. Thread-safe. The
/// functions throw std::bad_alloc. O(n log n) for n numbers.
struct LineTransforms {
    /// Computes the DCT-II in place: Y[k] = 2 sum over j of y[j] cos(pi k (j + 1/2) / size).
    void (*cosine)(const LineSet& lines, double* values);

    /// Computes the DCT-III in place: cosine() followed by cosine_back() multiplies by 2 * size.
    void (*cosine_back)(const LineSet& lines, double* values);

    /// Computes Y[k] = sum over j of y[j] e^(-2 pi i k j / size), for k from 0 to size / 2.
    /// @param apart  distance between successive lines of coefficients; the coefficients of a line are contiguous
    void (*real)(const LineSet& lines, const double* values, std::size_t apart, std::complex<double>* coefficients);

    /// Computes the inverse of real(): real() followed by real_back() multiplies by size.
    void (*real_back)(const LineSet& lines, double* values, std::size_t apart,
                      const std::complex<double>* coefficients);

    /// Computes the sum of real() in place, for all k.
    void (*complex)(const LineSet& lines, std::complex<double>* values);

    /// Computes the inverse of complex() in place: complex() followed by complex_back() multiplies by size.
    void (*complex_back)(const LineSet& lines, std::complex<double>* values);
};

}  // namespace ccdt

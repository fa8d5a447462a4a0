#pragma once

#include <complex>
#include <cstddef>

namespace ccdt {

/// Lines of numbers side by side; all distances in numbers.
struct LineSet {
    std::size_t size;   ///< of a line, >= 1
    std::size_t step;   ///< from a number to the next one of its line
    std::size_t count;  ///< of lines, >= 1
    std::size_t apart;  ///< from a line to the next one
};

/// Transforms of lines, some of them at once: what comes of a line is the same to the bit whatever lies beside it, and
/// whichever processor does it. By pocketfft (Reinecke 2019), which remembers what it computed for the last sizes. Safe
/// from any thread. Throw std::bad_alloc. O(n log n) for n numbers.
struct LineTransforms {
    /// In place, DCT-II: Y[k] = 2 sum over j of y[j] cos(pi k (j + 1/2) / size).
    void (*cosine)(const LineSet& lines, double* values);

    /// In place, DCT-III: cosine(), then this, multiplies by 2 * size.
    void (*cosine_back)(const LineSet& lines, double* values);

    /// Y[k] = sum over j of y[j] e^(-2 pi i k j / size), for k from 0 to size / 2.
    /// @param apart  from a line of coefficients, which lie next to each other, to the next one
    void (*real)(const LineSet& lines, const double* values, std::size_t apart, std::complex<double>* coefficients);

    /// The other way: real(), then this, multiplies by size.
    void (*real_back)(const LineSet& lines, double* values, std::size_t apart,
                      const std::complex<double>* coefficients);

    /// In place, as real() for all k.
    void (*complex)(const LineSet& lines, std::complex<double>* values);

    /// In place: complex(), then this, multiplies by size.
    void (*complex_back)(const LineSet& lines, std::complex<double>* values);
};

/// For every processor of the architecture.
const LineTransforms& common_line_transforms();

/// The fastest that this processor can do.
const LineTransforms& line_transforms();

}  // namespace ccdt

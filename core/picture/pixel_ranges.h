// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Number of pixels, or equivalent work, in a parallel task.
inline constexpr std::size_t kPixelsOfTask = std::size_t{1} << 15;

/// Number of pixels per sequential sum. These sums are added in order, so no result depends on the number of threads.
inline constexpr std::size_t kPixelsOfSum = std::size_t{1} << 20;

/// Returns the number of pixel rows in a parallel task.
/// @param width  >= 1
constexpr std::size_t rows_of_task(int width) {
    const std::size_t rows = kPixelsOfTask / static_cast<std::size_t>(width);
    return rows > 0 ? rows : 1;
}

/// Calls work(pixel) for each pixel, on the threads of an executor.
template <class Work>
void for_pixels(Executor& executor, std::size_t pixels, const Work& work) {
    for_ranges(executor, pixels, kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) work(i);
    });
}

/// Calls work(row) for each row of pixels, on the threads of an executor.
/// @param width  >= 1
template <class Work>
void for_rows(Executor& executor, int width, std::size_t rows, const Work& work) {
    for_ranges(executor, rows, rows_of_task(width), [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) work(row);
    });
}

/// Returns the sum of value(i) over all pixels i. Deterministic for any number of threads.
template <class Value>
double sum_of_pixels(Executor& executor, std::size_t pixels, const Value& value) {
    std::vector<double> sums((pixels + kPixelsOfSum - 1) / kPixelsOfSum, 0.0);
    for_ranges(executor, pixels, kPixelsOfSum, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += value(i);
        sums[begin / kPixelsOfSum] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// Returns the sum of values in the manner of sum_of_pixels().
inline double sum_of(Executor& executor, std::span<const float> values) {
    return sum_of_pixels(executor, values.size(), [&](std::size_t i) { return static_cast<double>(values[i]); });
}

}  // namespace ccdt

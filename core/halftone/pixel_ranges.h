// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include "core/parallel/executor.h"

namespace ccdt {

/// Pixels, or as much work, that are worth a task of their own.
inline constexpr std::size_t kPixelsOfTask = std::size_t{1} << 15;

/// Pixels that are added up one after the other. The sums of such ranges are added in order, so that a sum is the same
/// whoever adds it.
inline constexpr std::size_t kPixelsOfSum = std::size_t{1} << 20;

/// Rows that are worth a task of their own.
/// @param width  >= 1
constexpr std::size_t rows_of_task(int width) {
    const std::size_t rows = kPixelsOfTask / static_cast<std::size_t>(width);
    return rows > 0 ? rows : 1;
}

/// Calls value(i) for each of so many pixels, and adds up what that gives.
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

}  // namespace ccdt

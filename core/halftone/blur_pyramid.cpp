// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/blur_pyramid.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/halftone/bilinear.h"
#include "core/halftone/pixel_ranges.h"

namespace ccdt {

namespace {

using Kernel = std::array<float, 5>;

/// Binomial weights, with a variance of 1 squared pixel.
constexpr Kernel kWide = {1 / 16.0f, 4 / 16.0f, 6 / 16.0f, 4 / 16.0f, 1 / 16.0f};

/// Weights with a variance of 2/3 squared pixels of the coarser level. The blur of the finer level adds 1/4, and
/// averaging 2 x 2 pixels adds 1/16, so a level has a total variance of about 1.
constexpr Kernel kNext = {1 / 36.0f, 8 / 36.0f, 18 / 36.0f, 8 / 36.0f, 1 / 36.0f};

/// Filters along the columns, then along the rows. The pixels at the border are repeated outside.
void filter(std::vector<float>& values, int width, int height, const Kernel& kernel, std::vector<float>& scratch,
            Executor& executor) {
    const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
    scratch.resize(values.size());
    for_ranges(executor, rows, rows_of_task(width), [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            std::array<const float*, 5> from;
            for (std::size_t k = 0; k < 5; ++k) {
                const std::size_t row = std::min(y + k < 2 ? 0 : y + k - 2, rows - 1);
                from[k] = values.data() + row * columns;
            }
            float* to = scratch.data() + y * columns;
            for (std::size_t x = 0; x < columns; ++x)
                to[x] = kernel[2] * from[2][x] + kernel[1] * (from[1][x] + from[3][x]) +
                        kernel[0] * (from[0][x] + from[4][x]);
        }
    });
    for_ranges(executor, rows, rows_of_task(width), [&](std::size_t begin, std::size_t end) {
        std::vector<float> padded(columns + 4);
        for (std::size_t y = begin; y < end; ++y) {
            const float* from = scratch.data() + y * columns;
            std::copy_n(from, columns, padded.begin() + 2);
            padded[0] = padded[1] = from[0];
            padded[columns + 2] = padded[columns + 3] = from[columns - 1];
            float* to = values.data() + y * columns;
            for (std::size_t x = 0; x < columns; ++x)
                to[x] = kernel[2] * padded[x + 2] + kernel[1] * (padded[x + 1] + padded[x + 3]) +
                        kernel[0] * (padded[x] + padded[x + 4]);
        }
    });
}

/// Averages blocks of 2 x 2 pixels. If a side is odd, the last row or column is repeated.
void halve(const std::vector<float>& values, int width, int height, std::vector<float>& result) {
    const int columns = (width + 1) / 2, rows = (height + 1) / 2;
    float* to = result.data();
    const auto row = [&](int y) {
        return values.data() + static_cast<std::size_t>(std::min(y, height - 1)) * static_cast<std::size_t>(width);
    };
    for (int y = 0; y < rows; ++y) {
        const float *upper = row(2 * y), *lower = row(2 * y + 1);
        for (int x = 0; x < columns; ++x) {
            const int left = 2 * x, right = std::min(left + 1, width - 1);
            *to++ = (upper[left] + upper[right] + lower[left] + lower[right]) / 4;
        }
    }
}

}  // namespace

BlurPyramid::BlurPyramid(int width, int height, double widest) {
    constexpr int kMinSide = 4;  // smallest side of a level, pixels
    double reached = 1;
    while (true) {
        const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        levels_.push_back({width, height, std::vector<float>(pixels)});
        if (reached >= widest || std::min(width, height) < 2 * kMinSide) return;
        reached *= 2;
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    }
}

void BlurPyramid::assign(const std::vector<float>& values, Executor& executor) {
    assert(values.size() == levels_.front().values.size());
    for (std::size_t k = 0; k < levels_.size(); ++k) {
        Level& level = levels_[k];
        if (k == 0) {
            std::ranges::copy(values, level.values.begin());
        } else {
            halve(levels_[k - 1].values, levels_[k - 1].width, levels_[k - 1].height, level.values);
        }
        filter(level.values, level.width, level.height, k == 0 ? kWide : kNext, scratch_, executor);
    }
}

BlurPyramid::LevelSample BlurPyramid::sample(std::size_t level, Point place) const {
    const Point inside = 1 / static_cast<double>(std::size_t{1} << level) * place;
    const BetweenPixels x(inside.x, levels_[level].width), y(inside.y, levels_[level].height);
    return {level, y.first * static_cast<std::size_t>(levels_[level].width) + x.first, x.share, y.share};
}

BlurPyramid::Sample BlurPyramid::sample(Point place, double sigma) const {
    const auto last = static_cast<double>(levels_.size() - 1);
    const double level = std::clamp(std::log2(std::max(sigma, 1.0)), 0.0, last);
    const auto finer = static_cast<std::size_t>(level);
    const auto share = static_cast<float>(level - static_cast<double>(finer));
    return {sample(finer, place), sample(std::min(finer + 1, levels_.size() - 1), place), share};
}

}  // namespace ccdt

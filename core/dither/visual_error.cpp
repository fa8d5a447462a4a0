// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/visual_error.h"

#include "core/base/elementary.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// Returns the autocorrelation of a Gaussian that is cut off at 4 squares and has the sum 1.
template <std::size_t Side>
std::array<float, Side> autocorrelation(double blur) {
    constexpr int kReach = static_cast<int>(Side) / 2, kRadius = kReach / 2;
    std::array<double, 2 * kRadius + 1> gaussian{};
    double sum = 0;
    for (std::size_t i = 0; i < gaussian.size(); ++i) {
        const double distance = static_cast<double>(i) - kRadius;
        gaussian[i] = elementary::exp(-distance * distance / (2 * blur * blur));
        sum += gaussian[i];
    }
    std::array<float, Side> result{};
    for (std::size_t shift = 0; shift < Side; ++shift) {
        double product = 0;
        for (std::size_t i = 0; i < gaussian.size(); ++i) {
            const auto j = static_cast<std::ptrdiff_t>(i + shift) - kReach;
            if (j >= 0 && j < std::ssize(gaussian)) product += gaussian[i] * gaussian[static_cast<std::size_t>(j)];
        }
        result[shift] = static_cast<float>(product / (sum * sum));
    }
    return result;
}

}  // namespace

template <std::size_t Channels>
VisualError<Channels>::VisualError(std::span<const Colour> residual, int width, int height, double blur,
                                   Executor& executor)
    : kernel_(autocorrelation<index(kSide)>(blur)) {
    for (int l = 0; l < kLevels; ++l) {
        fill(l, residual, width, height, executor);
        self_ += kWeights[index(l)] * kernel_[kReach] * kernel_[kReach];
        for (int y = 0; y <= kPhaseMask; ++y) {
            for (int x = 0; x <= kPhaseMask; ++x) {
                for (int near = 0; near < kNearSide * kNearSide; ++near) {
                    const int columns = ((x + near % kNearSide - kNear) >> l) - (x >> l);
                    const int rows = ((y + near / kNearSide - kNear) >> l) - (y >> l);
                    mutual_[index(y)][index(x)][index(near)] +=
                        kWeights[index(l)] * kernel_[index(kReach + columns)] * kernel_[index(kReach + rows)];
                }
            }
        }
    }
}

/// Computes the stored values of level l: sums of the residual over squares, filtered along rows, then along columns.
template <std::size_t Channels>
void VisualError<Channels>::fill(int l, std::span<const Colour> residual, int width, int height, Executor& executor) {
    Level& level = levels_[index(l)];
    level.width = (width + (1 << l) - 1) >> l;
    level.height = (height + (1 << l) - 1) >> l;
    level.stride = Channels * index(level.width + 2 * kReach);
    const std::size_t row_size = Channels * index(level.width);
    std::vector<float> rows(row_size * index(level.height), 0.0f);
    const std::size_t rows_per_task = rows_of_task(level.width);
    for_ranges(executor, index(level.height), rows_per_task, [&](std::size_t begin, std::size_t end) {
        std::vector<float> sums(row_size + 2 * Channels * kReach);
        for (std::size_t row = begin; row < end; ++row) {
            std::ranges::fill(sums, 0.0f);
            const int bottom = std::min(height, (static_cast<int>(row) + 1) << l);
            for (int y = static_cast<int>(row) << l; y < bottom; ++y) {
                for (int x = 0; x < width; ++x) {
                    const Colour& value = residual[index(y) * index(width) + index(x)];
                    float* const sum = &sums[Channels * index((x >> l) + kReach)];
                    for (std::size_t c = 0; c < Channels; ++c) sum[c] += value[c];
                }
            }
            float* const blurred = &rows[row * row_size];
            for (std::size_t k = 0; k < kernel_.size(); ++k) {
                for (std::size_t i = 0; i < row_size; ++i) blurred[i] += kernel_[k] * sums[i + k * Channels];
            }
        }
    });
    level.values.assign(level.stride * index(level.height + 2 * kReach), 0.0f);
    for_ranges(executor, index(level.height), rows_per_task, [&](std::size_t begin, std::size_t end) {
        for (auto row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
            float* const value = level.at(0, row);
            for (int other = std::max(0, row - kReach); other <= std::min(level.height - 1, row + kReach); ++other) {
                const float factor = kWeights[index(l)] * kernel_[index(other - row + kReach)];
                const float* const blurred = &rows[index(other) * row_size];
                for (std::size_t i = 0; i < row_size; ++i) value[i] += factor * blurred[i];
            }
        }
    });
}

template class VisualError<1>;
template class VisualError<4>;

}  // namespace ccdt

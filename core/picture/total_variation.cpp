// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/total_variation.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// Solver state: the dual field, its extrapolation (both one vector per pixel), and the smoothed image.
class TotalVariation {
public:
    TotalVariation(const std::vector<float>& values, int width, int height, float strength, Executor& executor)
        : values_(values),
          columns_(static_cast<std::size_t>(width)),
          rows_(static_cast<std::size_t>(height)),
          strength_(strength),
          executor_(executor),
          dual_x_(values.size()),
          dual_y_(values.size()),
          ahead_x_(values.size()),
          ahead_y_(values.size()),
          smooth_(values.size()) {}

    std::vector<float> solve(int steps) {
        float t = 1;
        for (int i = 0; i < steps; ++i) {
            smooth(ahead_x_, ahead_y_);
            const float next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
            ascend((t - 1) / next);
            t = next;
        }
        smooth(dual_x_, dual_y_);
        return std::move(smooth_);
    }

private:
    /// Sets the image to the values plus `strength` times the divergence of a dual field.
    void smooth(const std::vector<float>& x, const std::vector<float>& y) {
        for_rows(executor_, static_cast<int>(columns_), rows_, [&](std::size_t row) {
            const std::size_t first = row * columns_;
            const float *across = x.data() + first, *down = y.data() + first, *value = values_.data() + first;
            const float* above = row > 0 ? down - columns_ : nullptr;
            float* to = smooth_.data() + first;
            for (std::size_t c = 0; c < columns_; ++c) to[c] = across[c] + down[c];
            for (std::size_t c = 1; c < columns_; ++c) to[c] -= across[c - 1];
            if (above != nullptr) {
                for (std::size_t c = 0; c < columns_; ++c) to[c] -= above[c];
            }
            for (std::size_t c = 0; c < columns_; ++c) to[c] = value[c] + strength_ * to[c];
        });
    }

    /// Takes a gradient step of the dual field, limits the lengths of its vectors to 1, and extrapolates it.
    void ascend(float momentum) {
        const float step = 1 / (8 * strength_);
        for_rows(executor_, static_cast<int>(columns_), rows_, [&](std::size_t row) {
            const std::size_t first = row * columns_;
            const float* here = smooth_.data() + first;
            const float* below = row + 1 < rows_ ? here + columns_ : here;
            float *x = dual_x_.data() + first, *y = dual_y_.data() + first;
            float *next_x = ahead_x_.data() + first, *next_y = ahead_y_.data() + first;
            // The compiler vectorises loops over short local arrays.
            constexpr std::size_t kBlock = 64;
            std::array<float, kBlock> across, down;
            for (std::size_t begin = 0; begin < columns_; begin += kBlock) {
                const std::size_t count = std::min(kBlock, columns_ - begin);
                for (std::size_t i = 0; i < count; ++i) across[i] = -here[begin + i];
                for (std::size_t i = 0; i + 1 < count; ++i) across[i] += here[begin + i + 1];
                across[count - 1] += here[std::min(begin + count, columns_ - 1)];
                for (std::size_t i = 0; i < count; ++i) across[i] = next_x[begin + i] + step * across[i];
                for (std::size_t i = 0; i < count; ++i)
                    down[i] = next_y[begin + i] + step * (below[begin + i] - here[begin + i]);
                for (std::size_t i = 0; i < count; ++i) {
                    const float scale = 1 / std::max(1.0f, std::sqrt(across[i] * across[i] + down[i] * down[i]));
                    across[i] *= scale;
                    down[i] *= scale;
                }
                advance(across.data(), count, momentum, x + begin, next_x + begin);
                advance(down.data(), count, momentum, y + begin, next_y + begin);
            }
        });
    }

    /// Sets one component of the dual field to `to`. Extrapolates the change and writes the result to `ahead`.
    static void advance(const float* to, std::size_t count, float momentum, float* dual, float* ahead) {
        for (std::size_t i = 0; i < count; ++i) {
            ahead[i] = to[i] + momentum * (to[i] - dual[i]);
            dual[i] = to[i];
        }
    }

    const std::vector<float>& values_;
    std::size_t columns_, rows_;
    float strength_;
    Executor& executor_;
    std::vector<float> dual_x_, dual_y_, ahead_x_, ahead_y_, smooth_;
};

}  // namespace

std::vector<float> denoised(const std::vector<float>& values, int width, int height, float strength, int steps,
                            Executor& executor) {
    assert(width >= 1 && height >= 1 && strength > 0 && steps >= 1);
    return TotalVariation(values, width, height, strength, executor).solve(steps);
}

}  // namespace ccdt

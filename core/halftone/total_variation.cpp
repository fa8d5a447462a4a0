// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/total_variation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/halftone/pixel_ranges.h"

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
    template <class Work>
    void for_rows(const Work& work) {
        for_ranges(executor_, rows_, rows_of_task(static_cast<int>(columns_)), [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) work(row);
        });
    }

    /// Sets the image to the values plus `strength` times the divergence of a dual field.
    void smooth(const std::vector<float>& x, const std::vector<float>& y) {
        for_rows([&](std::size_t row) {
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

    /// Takes a gradient step of the dual field, projects it onto unit vectors, and extrapolates.
    void ascend(float momentum) {
        const float step = 1 / (8 * strength_);
        for_rows([&](std::size_t row) {
            const std::size_t first = row * columns_;
            const float* here = smooth_.data() + first;
            const float* below = row + 1 < rows_ ? here + columns_ : here;
            float *x = dual_x_.data() + first, *y = dual_y_.data() + first;
            float *next_x = ahead_x_.data() + first, *next_y = ahead_y_.data() + first;
            const auto update = [&](std::size_t c, float right) {
                const float across = next_x[c] + step * (right - here[c]);
                const float down = next_y[c] + step * (below[c] - here[c]);
                const float scale = 1 / std::max(1.0f, std::sqrt(across * across + down * down));
                const float new_x = scale * across, new_y = scale * down;
                next_x[c] = new_x + momentum * (new_x - x[c]);
                next_y[c] = new_y + momentum * (new_y - y[c]);
                x[c] = new_x;
                y[c] = new_y;
            };
            for (std::size_t c = 0; c + 1 < columns_; ++c) update(c, here[c + 1]);
            update(columns_ - 1, here[columns_ - 1]);
        });
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

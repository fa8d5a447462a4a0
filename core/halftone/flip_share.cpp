// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/flip_share.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/halftone/blur.h"
#include "core/halftone/pixel_ranges.h"

namespace ccdt {

namespace {

/// Returns the mean light of the cells that lie completely on one ground, within 2 columns and 2 rows of a cell.
/// @param ground    1 for white, 0 for black
/// @param fallback  result if there are no such cells
float light_beside(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                   std::size_t cell, float ground, float fallback) {
    constexpr int kReach = 2;
    const int column = static_cast<int>(cell % static_cast<std::size_t>(cells.columns));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(cells.columns));
    float sum = 0, count = 0;
    for (int y = std::max(row - kReach, 0); y <= std::min(row + kReach, cells.rows - 1); ++y) {
        for (int x = std::max(column - kReach, 0); x <= std::min(column + kReach, cells.columns - 1); ++x) {
            const std::size_t other =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(cells.columns) + static_cast<std::size_t>(x);
            if (white[other] != ground) continue;
            sum += light[other];
            ++count;
        }
    }
    return count > 0 ? sum / count : fallback;
}

}  // namespace

std::vector<float> flip_share(const std::vector<float>& light, const std::vector<float>& white, const CellGrid& cells,
                              Executor& executor) {
    std::vector<float> share(light.size());
    for_pixels(executor, light.size(), [&](std::size_t i) {
        if (white[i] == 0 || white[i] == 1) {
            share[i] = std::abs(light[i] - white[i]);
        } else {
            const float on_white = light_beside(light, white, cells, i, 1, light[i]);
            const float on_black = light_beside(light, white, cells, i, 0, light[i]);
            share[i] = white[i] * (1 - on_white) + (1 - white[i]) * on_black;
        }
    });
    return share;
}

void clear_thin_ground(const std::vector<float>& white, const CellGrid& cells, double radius, std::vector<float>& share,
                       Executor& executor) {
    constexpr float kNothing = 1e-9f;
    std::vector<float> scratch, majority = white;
    blur(majority, cells.columns, cells.rows, radius, scratch, executor);
    const auto is_thin = [&](std::size_t i) { return (white[i] > 0.5f) != (majority[i] > 0.5f); };
    // Shares that dots flip on thin ground and on other ground: positive for ink dots, negative for paper dots.
    std::vector<float> thin(share.size()), other(share.size());
    for_pixels(executor, share.size(),
               [&](std::size_t i) { (is_thin(i) ? thin : other)[i] = white[i] > 0.5f ? share[i] : -share[i]; });
    blur(thin, cells.columns, cells.rows, radius, scratch, executor);
    blur(other, cells.columns, cells.rows, radius, scratch, executor);
    for_pixels(executor, share.size(), [&](std::size_t i) {
        const float sign = white[i] > 0.5f ? 1.0f : -1.0f;
        const float own = std::max(sign * other[i], kNothing);
        share[i] = is_thin(i) ? 0 : share[i] * std::clamp(1 + sign * thin[i] / own, 0.0f, 1.0f);
    });
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Visits the pixels of a picture in sweeps, until a visit changes nearly no pixel.
///
/// Tiles are visited in parallel. A sweep skips blocks of pixels around which the previous sweep has changed nothing.
class TileSweep {
public:
    static constexpr int kTile = 160;  ///< side of a tile, in pixels

    TileSweep(int width, int height)
        : width_(width),
          height_(height),
          columns_((width + kBlock - 1) / kBlock),
          rows_((height + kBlock - 1) / kBlock),
          is_due_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 1),
          is_due_next_(is_due_.size(), 0) {}

    /// Repeats sweeps.
    /// @param visit  bool(int x, int y): visits a pixel, and returns whether it has changed something; what it reads
    ///               and writes is less than kTile / 2 pixels away, along each axis
    /// @param stop   polled many times in each sweep
    /// Deterministic for any number of threads.
    template <class Visit>
    void run(const Visit& visit, const std::stop_token& stop, Executor& executor) {
        constexpr int kMaxSweeps = 30;
        constexpr std::size_t kPixelsPerChange = 2000;  // a sweep with fewer changes is the last one
        const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        for (int i = 0; i < kMaxSweeps && !stop.stop_requested(); ++i) {
            if (sweep(visit, stop, executor) <= pixels / kPixelsPerChange) break;
        }
    }

private:
    static constexpr int kBlock = 8;  ///< side of a block, in pixels; blocks are skipped as a whole

    /// Visits the pixels once. Tiles of one phase are so far apart that no tile's changes touch what another one reads.
    /// @returns  number of changes
    template <class Visit>
    std::size_t sweep(const Visit& visit, const std::stop_token& stop, Executor& executor) {
        const int columns = (width_ + kTile - 1) / kTile, rows = (height_ + kTile - 1) / kTile;
        std::atomic<std::size_t> changes = 0;
        for (int phase = 0; phase < 4; ++phase) {
            const int left = phase % 2, top = phase / 2;
            const int across = (columns - left + 1) / 2, down = (rows - top + 1) / 2;
            const std::size_t tasks = static_cast<std::size_t>(across) * static_cast<std::size_t>(down);
            executor.run(tasks, [&](std::size_t task) {
                const int column = static_cast<int>(task) % across, row = static_cast<int>(task) / across;
                changes += visit_tile(visit, (2 * column + left) * kTile, (2 * row + top) * kTile, stop);
            });
        }
        is_due_.swap(is_due_next_);
        std::ranges::fill(is_due_next_, std::uint8_t{0});
        return changes;
    }

    template <class Visit>
    std::size_t visit_tile(const Visit& visit, int left, int top, const std::stop_token& stop) {
        const int right = std::min(left + kTile, width_), bottom = std::min(top + kTile, height_);
        std::size_t changes = 0;
        for (int y = top; y < bottom && !stop.stop_requested(); y += kBlock) {
            for (int x = left; x < right; x += kBlock) {
                if (is_due_[block(x / kBlock, y / kBlock)] == 0) continue;
                changes += visit_block(visit, x, y, std::min(x + kBlock, right), std::min(y + kBlock, bottom));
            }
        }
        return changes;
    }

    template <class Visit>
    std::size_t visit_block(const Visit& visit, int left, int top, int right, int bottom) {
        std::size_t changes = 0;
        for (int y = top; y < bottom; ++y) {
            for (int x = left; x < right; ++x) {
                if (visit(x, y)) ++changes;
            }
        }
        if (changes > 0) mark_around(left / kBlock, top / kBlock);
        return changes;
    }

    /// Marks a block and its neighbours to be visited in the next sweep.
    void mark_around(int column, int row) {
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
            for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x)
                is_due_next_[block(x, y)] = 1;
        }
    }

    std::size_t block(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    }

    int width_, height_;
    int columns_, rows_;                     ///< numbers of blocks
    std::vector<std::uint8_t> is_due_;       ///< [blocks] whether a block is visited in this sweep
    std::vector<std::uint8_t> is_due_next_;  ///< [blocks] whether it is visited in the next sweep
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/threshold_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

/// Returns the variance of the number of pixels below a threshold in square blocks, relative to that of random pixels.
/// The blocks have all positions, including those across the seams of the tile.
double unevenness(const std::vector<std::uint32_t>& ranks, int side, int block, double share) {
    const double count = static_cast<double>(ranks.size()), least = share * count;
    double sum = 0;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            double below = 0;
            for (int j = 0; j < block; ++j) {
                for (int i = 0; i < block; ++i)
                    below += ranks[static_cast<std::size_t>((y + j) % side * side + (x + i) % side)] < least ? 1 : 0;
            }
            const double error = below - share * block * block;
            sum += error * error;
        }
    }
    return sum / count / (share * (1 - share) * block * block);
}

TEST(ThresholdMask, ContainsEachRankOnce) {
    for (const auto& [width, height] : {std::pair{8, 8}, {9, 13}, {64, 16}, {31, 97}}) {
        auto ranks = threshold_mask(width, height, 1, 1);
        std::ranges::sort(ranks);
        std::vector<std::uint32_t> all(static_cast<std::size_t>(width * height));
        std::iota(all.begin(), all.end(), 0U);
        EXPECT_EQ(ranks, all) << width << ' ' << height;
    }
}

TEST(ThresholdMask, IsEvenAtEveryThreshold) {
    constexpr int kSide = 128;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const auto ranks = threshold_mask(kSide, kSide, 1, seed);
        for (const double share : {1.0 / 64, 1.0 / 16, 0.15, 0.25, 0.4, 0.5, 0.6, 0.75, 0.85, 15.0 / 16, 63.0 / 64}) {
            // Blocks that contain about 16 of the rarer pixels.
            const int block = static_cast<int>(4 / std::sqrt(std::min(share, 1 - share)));
            EXPECT_LT(unevenness(ranks, kSide, block, share), 0.16) << share;
        }
    }
}

TEST(ThresholdMask, HasEachRankOnceInEachFrame) {
    constexpr std::size_t kFrame = 9 * 11;
    const auto ranks = threshold_mask(9, 11, 5, 1);
    ASSERT_EQ(ranks.size(), 5 * kFrame);
    for (std::size_t first = 0; first < ranks.size(); first += kFrame) {
        std::vector<bool> found(kFrame, false);
        for (std::size_t i = 0; i < kFrame; ++i) found.at(ranks[first + i]) = true;
        EXPECT_EQ(std::ranges::count(found, true), kFrame);
    }
}

/// Random ranks have 1 for both the blocks and the runs. Frames that are computed each by itself have 1 for the runs.
TEST(ThresholdMask, IsEvenInSpaceAndTime) {
    constexpr std::size_t kSide = 64, kFrame = kSide * kSide, kFrames = 16;
    const auto ranks = threshold_mask(kSide, kSide, kFrames, 3);
    for (const double share : {1.0 / 16, 0.25, 0.5, 0.8}) {
        const int block = static_cast<int>(4 / std::sqrt(std::min(share, 1 - share)));
        for (const std::size_t frame : {0, 7, 15}) {
            const auto first = ranks.begin() + static_cast<std::ptrdiff_t>(frame * kFrame);
            EXPECT_LT(unevenness({first, first + kFrame}, kSide, block, share), 0.24) << share;
        }
    }
    // Runs of frames, including those across the end of the tile.
    constexpr std::size_t kRun = 8;
    double sum = 0;
    for (std::size_t i = 0; i < ranks.size(); ++i) {
        double mean = 0;
        for (std::size_t k = 0; k < kRun; ++k) mean += ranks[(i + k * kFrame) % ranks.size()] / (kRun * 1.0 * kFrame);
        sum += (mean - 0.5) * (mean - 0.5);
    }
    EXPECT_LT(sum / static_cast<double>(ranks.size()), 0.2 / (12 * kRun));
}

TEST(ThresholdMask, IsDeterministicForASeed) {
    ThreadExecutor threads(2);
    EXPECT_EQ(threshold_mask(32, 24, 1, 1), threshold_mask(32, 24, 1, 1));
    EXPECT_EQ(threshold_mask(32, 24, 3, 1), threshold_mask(32, 24, 3, 1, {}, threads));
    EXPECT_NE(threshold_mask(32, 24, 1, 1), threshold_mask(32, 24, 1, 2));
}

TEST(ThresholdMask, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(threshold_mask(64, 64, 1, 1, source.get_token()).size(), 4'096U);
}

}  // namespace
}  // namespace ccdt

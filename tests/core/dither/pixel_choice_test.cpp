// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/pixel_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

using Pixels = std::vector<std::uint8_t>;

std::size_t area(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::size_t count_of(const Pixels& pixels) {
    return static_cast<std::size_t>(std::ranges::count(pixels, 1));
}

/// Returns a density that falls from the centre. It is 0 in the corners, and varies by 40 orders of magnitude.
Density falling(int width, int height) {
    std::vector<double> values;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double distance = std::hypot((x + 0.5) / width - 0.5, (y + 0.5) / height - 0.5);
            values.push_back(distance > 0.6 ? 0 : std::exp(-92 * distance * distance / 0.36));
        }
    }
    return *Density::grid(width, height, std::span<const double>(values));
}

/// Returns a mask of a rectangle in the centre.
Pixels centre(int width, int height, int columns, int rows) {
    Pixels included(area(width, height), 0);
    for (int y = (height - rows) / 2; y < (height + rows) / 2; ++y) {
        for (int x = (width - columns) / 2; x < (width + columns) / 2; ++x)
            included[area(width, y) + static_cast<std::size_t>(x)] = 1;
    }
    return included;
}

std::vector<double> shares_of(std::span<const double> density, std::size_t count, Pixels included = {}) {
    included.resize(density.size(), 0);
    const auto width = static_cast<int>(density.size());
    return *pixel_shares(*Density::grid(width, 1, density), included, width, 1, count);
}

Pixels uniform(int side, std::size_t count, std::uint64_t seed) {
    const auto shares = pixel_shares(Density::uniform(), Pixels(area(side, side), 0), side, side, count);
    return choose_pixels(*shares, side, side, seed);
}

/// Returns the variance of the number of chosen pixels in square blocks, relative to that of random pixels.
double unevenness(const Pixels& chosen, int side, int block) {
    const double share = static_cast<double>(count_of(chosen)) / static_cast<double>(chosen.size());
    double sum = 0, blocks = 0;
    for (int top = 0; top + block <= side; top += 3) {
        for (int left = 0; left + block <= side; left += 3) {
            double error = -share * block * block;
            for (int y = top; y < top + block; ++y) {
                for (int x = left; x < left + block; ++x) error += chosen[area(side, y) + static_cast<std::size_t>(x)];
            }
            sum += error * error;
            ++blocks;
        }
    }
    return sum / blocks / (share * (1 - share) * block * block);
}

/// Returns the number of pairs of chosen pixels that are neighbours in a row or a column.
std::size_t adjacent_pairs(const Pixels& chosen, int side) {
    const auto columns = static_cast<std::size_t>(side);
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (chosen[i] == 0) continue;
        if (i % columns + 1 < columns) pairs += chosen[i + 1];
        if (i + columns < chosen.size()) pairs += chosen[i + columns];
    }
    return pairs;
}

TEST(PixelShares, AreProportionalToTheDensityAndAtMostOne) {
    const std::vector<double> density = {1, 0, 2, 100, 1};
    EXPECT_EQ(shares_of(density, 2), (std::vector<double>{0.25, 0, 0.5, 1, 0.25}));
    EXPECT_EQ(shares_of(density, 3), (std::vector<double>{0.5, 0, 1, 1, 0.5}));
    EXPECT_EQ(shares_of(density, 4), (std::vector<double>{1, 0, 1, 1, 1}));
}

TEST(PixelShares, AreOneInIncludedPixels) {
    const std::vector<double> density = {1, 0, 2, 1};
    EXPECT_EQ(shares_of(density, 2, {0, 1}), (std::vector<double>{0.25, 1, 0.5, 0.25}));
    EXPECT_EQ(shares_of(density, 2, {1, 1}), (std::vector<double>{1, 1, 0, 0}));
    EXPECT_EQ(shares_of(density, 4, {0, 1}), (std::vector<double>{1, 1, 1, 1}));
}

TEST(PixelShares, IntegrateADensityOverPixels) {
    const std::vector<double> density = {1, 3, 0, 8};
    const auto wide = pixel_shares(*Density::grid(4, 1, std::span<const double>(density)), Pixels(2, 0), 2, 1, 1);
    EXPECT_NEAR((*wide)[0], 1.0 / 3, 1e-12);
    EXPECT_NEAR((*wide)[1], 2.0 / 3, 1e-12);
    const auto tall = pixel_shares(*Density::grid(1, 2, std::span(density).first<2>()), Pixels(4, 0), 1, 4, 1);
    EXPECT_NEAR((*tall)[1], 1.0 / 8, 1e-12);
    EXPECT_NEAR((*tall)[2], 3.0 / 8, 1e-12);
}

TEST(PixelShares, AreFoundIfRoundingMovesTheLimit) {
    // Pixels of the bottom rows have the density of the limit, those of the middle row have half of it.
    const std::vector<double> density = {0, 0, 0, 9e307};
    const auto shares = pixel_shares(*Density::grid(2, 2, std::span<const double>(density)), Pixels(40, 0), 8, 5, 10);
    EXPECT_NEAR(std::accumulate(shares->begin(), shares->end(), 0.0), 10, 1e-12);
    EXPECT_NEAR((*shares)[20], 0.5, 1e-12);
    EXPECT_NEAR((*shares)[39], 1, 1e-12);
}

TEST(PixelShares, RejectCountsThatCannotBeReached) {
    const std::vector<double> density = {1, 0, 2, 1};
    const auto error_of = [&](std::size_t count, const Pixels& included) {
        const auto shares = pixel_shares(*Density::grid(4, 1, std::span<const double>(density)), included, 4, 1, count);
        return shares ? "" : shares.error().field;
    };
    EXPECT_EQ(error_of(4, {0, 0, 0, 0}), "sites");
    EXPECT_EQ(error_of(4, {0, 1, 0, 0}), "");
    EXPECT_EQ(error_of(1, {1, 1, 0, 0}), "include");
    EXPECT_EQ(error_of(2, {1, 1, 0, 0}), "");
}

TEST(PixelChoice, HasExactlyTheNumberOfPixels) {
    int sets = 0;
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 97}, {64, 1}, {2, 2}, {31, 17}, {128, 128}, {300, 77}}) {
        for (const double divisor : {1.0, 1.001, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 64.0, 1e9}) {
            const auto count =
                static_cast<std::size_t>(std::max(1.0, std::floor(static_cast<double>(area(width, height)) / divisor)));
            for (const Density& density : {Density::uniform(), falling(width, height), falling(5, 3)}) {
                for (const int side : {0, 8}) {
                    const Pixels included = centre(width, height, std::min(side, width), std::min(side, height));
                    const auto shares = pixel_shares(density, included, width, height, count);
                    if (!shares) continue;
                    ++sets;
                    const Pixels chosen = choose_pixels(*shares, width, height, 1);
                    ASSERT_EQ(count_of(chosen), count) << width << " x " << height << " / " << divisor;
                    for (std::size_t i = 0; i < chosen.size(); ++i) {
                        ASSERT_TRUE(chosen[i] == 1 || (*shares)[i] < 1);
                        ASSERT_TRUE(chosen[i] == 0 || (*shares)[i] > 0);
                    }
                }
            }
        }
    }
    EXPECT_GT(sets, 300);  // the rest has too few pixels with a density, or too many that are included
}

TEST(PixelChoice, IsTheSameForAnyNumberOfThreads) {
    constexpr int kWidth = 401, kHeight = 333;
    const Density density = falling(64, 64);
    const auto choose = [&](Executor& executor) {
        const Pixels included = centre(kWidth, kHeight, 24, 24);
        const auto shares = pixel_shares(density, included, kWidth, kHeight, 30'000, executor);
        return choose_pixels(*shares, kWidth, kHeight, 5, {}, executor);
    };
    const Pixels expected = choose(inline_executor());
    for (const std::size_t threads : {2, 3, 16}) {
        ThreadExecutor executor(threads);
        EXPECT_EQ(choose(executor), expected) << threads;
    }
}

TEST(PixelChoice, DependsOnTheSeed) {
    EXPECT_EQ(uniform(64, 500, 1), uniform(64, 500, 1));
    // Two random sets have an eighth of their pixels in common.
    const Pixels first = uniform(64, 512, 1), second = uniform(64, 512, 2);
    std::size_t common = 0;
    for (std::size_t i = 0; i < first.size(); ++i) common += first[i] & second[i];
    EXPECT_LT(common, 128U);
}

TEST(PixelChoice, IsSpreadEvenly) {
    constexpr int kSide = 256;
    for (const int divisor : {2, 3, 4, 6, 8, 10, 16, 64}) {
        const Pixels chosen = uniform(kSide, area(kSide, kSide) / static_cast<std::size_t>(divisor), 1);
        const int block = static_cast<int>(4 * std::sqrt(divisor));
        EXPECT_LT(unevenness(chosen, kSide, block), 0.16) << divisor;
    }
}

TEST(PixelChoice, HasFewNeighbours) {
    constexpr int kSide = 256;
    EXPECT_EQ(adjacent_pairs(uniform(kSide, area(kSide, kSide) / 6, 1), kSide), 0U);
    EXPECT_EQ(adjacent_pairs(uniform(kSide, area(kSide, kSide) / 8, 1), kSide), 0U);
    // Of random pixels, an eighth of all pairs would be chosen.
    EXPECT_LT(adjacent_pairs(uniform(kSide, area(kSide, kSide) / 4, 1), kSide), area(kSide, kSide) / 400);
}

TEST(PixelChoice, FollowsTheSharesInAllParts) {
    constexpr int kSide = 192, kBlock = 24;
    const Density density = falling(kSide, kSide);
    const auto shares = pixel_shares(density, Pixels(area(kSide, kSide), 0), kSide, kSide, 9'000);
    const Pixels chosen = choose_pixels(*shares, kSide, kSide, 1);
    for (int top = 0; top < kSide; top += kBlock) {
        for (int left = 0; left < kSide; left += kBlock) {
            double wanted = 0, found = 0;
            for (int y = top; y < top + kBlock; ++y) {
                for (int x = left; x < left + kBlock; ++x) {
                    wanted += (*shares)[area(kSide, y) + static_cast<std::size_t>(x)];
                    found += chosen[area(kSide, y) + static_cast<std::size_t>(x)];
                }
            }
            EXPECT_NEAR(found, wanted, 6) << left << ' ' << top;
        }
    }
}

TEST(PixelChoice, IsExactAfterAStop) {
    std::stop_source source;
    source.request_stop();
    const auto shares = pixel_shares(falling(100, 80), centre(100, 80, 10, 10), 100, 80, 1'000);
    EXPECT_EQ(count_of(choose_pixels(*shares, 100, 80, 1, source.get_token())), 1'000U);
}

}  // namespace
}  // namespace ccdt

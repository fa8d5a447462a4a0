// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/total_variation.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr int kSide = 64;

std::vector<float> image(const auto& value) {
    std::vector<float> values;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) values.push_back(static_cast<float>(value(x, y)));
    }
    return values;
}

float at(const std::vector<float>& values, int x, int y) {
    return values[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)];
}

TEST(TotalVariation, LowersContrastOfDiscByTwiceStrengthOverRadius) {
    constexpr double kRadius = 12;
    const auto disc = image([](int x, int y) { return std::hypot(x - 31.5, y - 31.5) < kRadius ? 1 : 0; });
    const auto smooth = denoised(disc, kSide, kSide, 1.2F, 300);
    // Nothing leaves the image, so the surroundings gain as much as the disc loses.
    const double area = std::acos(-1.0) * kRadius * kRadius;
    const double gained = 2 * std::acos(-1.0) * kRadius * 1.2 / (kSide * kSide - area);
    EXPECT_NEAR(at(smooth, 32, 32), 1 - 2 * 1.2 / kRadius, 0.02);
    EXPECT_NEAR(at(smooth, 3, 3), gained, 0.02);
}

TEST(TotalVariation, KeepsStraightEdgesSharp) {
    const auto edge = image([](int x, int) { return x < kSide / 2 ? 0.2 : 0.8; });
    const auto smooth = denoised(edge, kSide, kSide, 0.5F, 100);
    EXPECT_LT(at(smooth, kSide / 2 - 1, 30), 0.23F);
    EXPECT_GT(at(smooth, kSide / 2, 30), 0.77F);
}

TEST(TotalVariation, RemovesNoise) {
    Random random(3, 0);
    const auto noise = image([&](int, int) { return 0.4 + 0.2 * random.uniform(); });
    double squares = 0;
    for (const float value : denoised(noise, kSide, kSide, 0.3F, 60))
        squares += std::pow(static_cast<double>(value) - 0.5, 2);
    EXPECT_LT(std::sqrt(squares / (kSide * kSide)), 0.01);
}

}  // namespace
}  // namespace ccdt

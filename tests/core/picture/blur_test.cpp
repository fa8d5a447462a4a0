// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/blur.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Blurred, SpreadsPointBySigmaInBothDirections) {
    constexpr int kSide = 101, kMiddle = 50;
    std::vector<float> point(kSide * kSide);
    point[kMiddle * kSide + kMiddle] = 1;
    for (const double sigma : {0.0, 0.1, 0.4, 1.0, 2.5, 8.0}) {
        const std::vector<float> spread = blurred(point, kSide, kSide, sigma);
        double across = 0, down = 0;
        for (int i = 0; i < kSide * kSide; ++i) {
            const auto value = static_cast<double>(spread[static_cast<std::size_t>(i)]);
            across += value * std::pow(i % kSide - kMiddle, 2);
            down += value * std::pow(i / kSide - kMiddle, 2);
        }
        EXPECT_NEAR(sum(spread), 1, 1e-5) << sigma;
        EXPECT_NEAR(std::sqrt(across), sigma, 1e-3) << sigma;
        EXPECT_NEAR(std::sqrt(down), sigma, 1e-3) << sigma;
    }
}

std::vector<float> blurred_directly(std::vector<float> values, int width, int height, double sigma) {
    std::vector<float> scratch;
    blur_directly(values, width, height, sigma, scratch);
    return values;
}

TEST(BlurDirectly, SpreadsPointAsAGaussian) {
    constexpr int kWidth = 60, kHeight = 51, kX = 31, kY = 25;
    std::vector<float> point(kWidth * kHeight);
    point[kY * kWidth + kX] = 1;
    for (const double sigma : {0.7, 1.2, 2.5, 6.0}) {
        const std::vector<float> spread = blurred_directly(point, kWidth, kHeight, sigma);
        EXPECT_NEAR(sum(spread), 1, 1e-5) << sigma;
        for (int i = 0; i < kWidth * kHeight; ++i) {
            const double squared = std::pow(i % kWidth - kX, 2) + std::pow(i / kWidth - kY, 2);
            const double expected = std::exp(-squared / (2 * sigma * sigma)) / (2 * std::numbers::pi * sigma * sigma);
            EXPECT_NEAR(static_cast<double>(spread[static_cast<std::size_t>(i)]), expected, 0.006 / sigma) << sigma;
        }
    }
}

TEST(BlurDirectly, ReflectsAtBorders) {
    Random random(3, 0);
    for (const auto& [width, height] : {std::pair{40, 25}, {1, 1}, {3, 1}, {1, 5}, {2, 2}}) {
        std::vector<float> values(static_cast<std::size_t>(width * height));
        for (float& value : values) value = static_cast<float>(random.uniform());
        for (const double sigma : {0.3, 3.0, 11.0}) {
            const std::vector<float> result = blurred_directly(values, width, height, sigma);
            EXPECT_NEAR(sum(result), sum(values), 1e-3) << width << " x " << height << ", sigma " << sigma;
            EXPECT_GE(std::ranges::min(result), std::ranges::min(values) - 1e-5f);
            EXPECT_LE(std::ranges::max(result), std::ranges::max(values) + 1e-5f);
        }
    }
}

TEST(Blurred, ReflectsAtBorders) {
    Random random(3, 0);
    std::vector<float> values(40 * 25);
    for (float& value : values) value = static_cast<float>(random.uniform());
    for (const double sigma : {0.3, 3.0, 11.0, 1000.0}) {
        const std::vector<float> result = blurred(values, 40, 25, sigma);
        EXPECT_NEAR(sum(result), sum(values), 1e-3) << "the sum changes at sigma " << sigma;
        const auto [least, most] = std::ranges::minmax(result);
        EXPECT_GE(least, std::ranges::min(values) - 1e-5f);
        EXPECT_LE(most, std::ranges::max(values) + 1e-5f);
    }
}

TEST(Blurred, AcceptsPlanesOfAnySize) {
    EXPECT_EQ(blurred({0.25f}, 1, 1, 7), (std::vector<float>{0.25f}));
    for (const float value : blurred(std::vector<float>(300, 0.5f), 300, 1, 40)) EXPECT_NEAR(value, 0.5f, 1e-6);
    for (const float value : blurred(std::vector<float>(300, 0.5f), 1, 300, 40)) EXPECT_NEAR(value, 0.5f, 1e-6);
}

}  // namespace
}  // namespace ccdt

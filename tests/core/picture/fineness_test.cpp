// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/fineness.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

constexpr int kSide = 64;

/// Returns a picture with the given lightness of each pixel.
template <class Lightness>
Picture drawn(const Lightness& lightness) {
    const auto light = std::make_shared<float[]>(kSide * kSide);
    for (int i = 0; i < kSide * kSide; ++i)
        light[i] = static_cast<float>(std::pow(static_cast<double>(lightness(i % kSide, i / kSide)), 2));
    return {kSide, kSide, Plane(light, kSide * kSide), {}};
}

TEST(Fineness, IsVarianceLostByAveragingTwoByTwoPixels) {
    EXPECT_NEAR(fineness(drawn([](int x, int y) { return (x + y) % 2; })), 1, 1e-6);
    EXPECT_NEAR(fineness(drawn([](int x, int) { return x / 2 % 2; })), 0, 1e-6);
    EXPECT_NEAR(fineness(drawn([](int x, int) { return (x + 1) / 2 % 2; })), 1, 1e-6);
    // Averaging removes the share sin^2(pi / L) from the variance of a wave of length L.
    const Picture wave = drawn([](int x, int) { return 0.5 + 0.3 * std::sin(2 * 3.141592653589793 * x / 16.0); });
    EXPECT_NEAR(fineness(wave), std::pow(std::sin(3.141592653589793 / 16), 2), 1e-5);
}

TEST(Fineness, IsZeroForFlatPictures) {
    for (const double light : {0.0, 0.3, 1.0}) EXPECT_EQ(fineness(drawn([&](int, int) { return light; })), 0);
    EXPECT_EQ(fineness(Picture{1, 3, {0, 1, 0}, {}}), 0);
    EXPECT_EQ(fineness(Picture{1, 1, {0.5F}, {}}), 0);
}

TEST(Fineness, DoesNotDependOnContrast) {
    const auto of_contrast = [](double contrast) {
        return fineness(drawn([&](int x, int y) { return 0.2 + contrast * (x * y % 7); }));
    };
    EXPECT_NEAR(of_contrast(0.1), of_contrast(0.01), 1e-4);
}

TEST(Fineness, TreatsTransparentPixelsAsWhite) {
    const Picture shown{4, 2, {0, 1, 0, 0, 0, 1, 1, 1}, {}};
    const Picture veiled{4, 2, {0, 0, 0, 0, 0, 0, 1, 1}, {1, 0, 1, 1, 1, 0, 1, 1}};
    EXPECT_DOUBLE_EQ(fineness(veiled), fineness(shown));
}

TEST(Fineness, UsesLuminanceOfColours) {
    const Plane light{0, 1, 0.5F, 0, 0.25F, 1, 1, 1};
    EXPECT_NEAR(fineness(ColourPicture{4, 2, light, light, light, {}}), fineness(Picture{4, 2, light, {}}), 1e-6);
}

TEST(Fineness, AcceptsNonFiniteNumbers) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Plane odd{-1, 2, kInfinity, std::numeric_limits<float>::quiet_NaN()};
    EXPECT_DOUBLE_EQ(fineness(Picture{2, 2, odd, {}}), fineness(Picture{2, 2, {0, 1, 1, 0}, {}}));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/blur_pyramid.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

constexpr int kSide = 256;

/// Returns the pyramid of an image.
BlurPyramid pyramid_of(const std::vector<float>& values, int width, int height, double widest) {
    BlurPyramid pyramid(width, height, widest);
    pyramid.assign(values);
    return pyramid;
}

TEST(BlurPyramid, AttenuatesWavesLikeGaussian) {
    for (const double sigma : {1.0, 2.0, 3.0, 4.0, 8.0}) {
        const double length = 8 * sigma;
        std::vector<float> wave;
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x)
                wave.push_back(static_cast<float>(std::cos(2 * std::numbers::pi * (x + 0.5 - kSide / 2) / length)));
        }
        const BlurPyramid means = pyramid_of(wave, kSide, kSide, 16);
        const double wanted = std::exp(-2 * std::pow(std::numbers::pi * sigma / length, 2));
        EXPECT_NEAR(means.at(means.sample({kSide / 2, kSide / 2}, sigma)), wanted, 0.1) << sigma;
    }
}

TEST(BlurPyramid, PreservesMeanOfImageOfOddSize) {
    const std::vector<float> flat(std::size_t{37} * 5, 0.25F);
    const BlurPyramid means = pyramid_of(flat, 37, 5, 100);
    for (const double sigma : {0.0, 1.0, 5.0, 1000.0}) EXPECT_FLOAT_EQ(means.at(means.sample({36, 1}, sigma)), 0.25F);
}

TEST(BlurPyramid, RemovesPatternsFinerThanBlur) {
    // The blur is as wide as the spacing of the dots, so it must remove their pattern.
    std::vector<float> dots(std::size_t{kSide} * kSide);
    for (std::size_t y = 3; y < kSide; y += 8) {
        for (std::size_t x = 3; x < kSide; x += 8) dots[y * kSide + x] = 64;
    }
    const BlurPyramid means = pyramid_of(dots, kSide, kSide, 8);
    for (const Point place : {Point{128, 128}, Point{131.5, 131.5}, Point{135, 129}})
        EXPECT_NEAR(means.at(means.sample(place, 8)), 1, 0.01);
}

}  // namespace
}  // namespace ccdt

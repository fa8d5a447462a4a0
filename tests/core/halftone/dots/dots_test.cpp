// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/dots.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr double kPi = 3.141592653589793;

std::vector<Point> scattered(std::size_t count, double width, double height) {
    Random random(1, 0);
    std::vector<Point> dots(count);
    for (Point& dot : dots) dot = {width * random.uniform(), height * random.uniform()};
    return dots;
}

/// Returns the covered area in pixels.
double ink_of(const Raster& raster) {
    return std::accumulate(raster.coverage.begin(), raster.coverage.end(), 0.0) / 255;
}

TEST(DrawDots, HasRequestedMeanCoverage) {
    // Many of the dots overlap.
    const Canvas canvas{150, 100, 1};
    const auto dots = scattered(300, 150, 100);
    for (int percent = 0; percent <= 100; ++percent) {
        const double wanted = percent / 100.0;
        const Raster binary = draw_dots(dots, canvas, {.mean_coverage = wanted});
        EXPECT_NEAR(ink_of(binary), wanted * 15000, 1) << percent;
        if (percent % 10 != 0) continue;
        const Raster smooth = draw_dots(dots, canvas, {.mean_coverage = wanted, .antialias = true});
        EXPECT_NEAR(ink_of(smooth) / 15000, wanted, 1e-3) << percent;
    }
}

TEST(DrawDots, HasSizeOfCanvas) {
    const Raster raster = draw_dots(scattered(300, 150, 100), {150, 100, 1}, {.mean_coverage = 0.3});
    EXPECT_EQ(raster.width, 150);
    EXPECT_EQ(raster.height, 100);
    EXPECT_EQ(raster.coverage.size(), 15000u);
    EXPECT_TRUE(
        std::all_of(raster.coverage.begin(), raster.coverage.end(), [](std::uint8_t c) { return c == 0 || c == 255; }));
}

TEST(DrawDots, DrawsDiscOfRequestedRadius) {
    const Point dot{50.3, 49.8};
    for (const double radius : {3.0, 10.5, 40.0}) {
        for (const bool antialias : {false, true}) {
            const Raster raster =
                draw_dots(std::span(&dot, 1), {100, 100, 1}, {.radius = radius, .antialias = antialias});
            EXPECT_EQ(raster.radius, radius);
            EXPECT_NEAR(ink_of(raster), kPi * radius * radius, antialias ? 1 : 4 * std::sqrt(radius));
        }
    }
}

TEST(DrawDots, CoversPixelsWhoseCentresAreInside) {
    const Point dot{2.5, 1.5};
    const Raster raster = draw_dots(std::span(&dot, 1), {5, 3, 1}, {.radius = 1.0});
    const std::vector<std::uint8_t> cross{0, 0, 255, 0, 0, 0, 255, 255, 255, 0, 0, 0, 255, 0, 0};
    EXPECT_EQ(raster.coverage, cross);
}

TEST(DrawDots, ScalesDots) {
    const auto dots = scattered(50, 20, 10);
    std::vector<Point> large(dots);
    for (Point& dot : large) dot = 4 * dot;
    EXPECT_EQ(draw_dots(dots, {80, 40, 4}, {.mean_coverage = 0.4}).coverage,
              draw_dots(large, {80, 40, 1}, {.mean_coverage = 0.4}).coverage);
}

TEST(DrawDots, MatchesAreaOfDiscsBySupersampling) {
    // The dots are smaller than a pixel, and some of them overlap.
    const Canvas canvas{150, 100, 1};
    const auto dots = scattered(6000, 150, 100);
    const Canvas large{1500, 1000, 10};
    const double discs = ink_of(draw_dots(dots, large, {.radius = 7.0})) / 100;
    EXPECT_EQ(samples_for(0.7, canvas, false), 5);
    for (const bool antialias : {false, true}) {
        const Raster raster = draw_dots(dots, canvas, {.radius = 0.7, .antialias = antialias, .samples = 5});
        EXPECT_EQ(raster.coverage.size(), 15000u);
        EXPECT_NEAR(raster.radius, 0.7, 1e-12);
        EXPECT_NEAR(ink_of(raster), discs, 0.01 * discs) << antialias;
    }
}

TEST(SamplesFor, IncreaseForSmallDots) {
    const Canvas canvas{1000, 1000, 1};
    EXPECT_EQ(samples_for(3, canvas, true), 1);
    EXPECT_EQ(samples_for(2.9, canvas, true), 2);
    EXPECT_EQ(samples_for(2.9, canvas, false), 1);
    EXPECT_EQ(samples_for(1, canvas, false), 3);
    EXPECT_EQ(samples_for(0.01, canvas, false), 4) << "16 million samples in all";
    EXPECT_EQ(samples_for(0.01, {8000, 8000, 1}, true), 1);
}

TEST(DrawDots, CountsOverlapsOnce) {
    const std::vector<Point> twice{{20.2, 20.1}, {20.2, 20.1}};
    const Canvas canvas{40, 40, 1};
    EXPECT_EQ(draw_dots(twice, canvas, {.radius = 7.0}).coverage,
              draw_dots(std::span(twice).first(1), canvas, {.radius = 7.0}).coverage);
    EXPECT_NEAR(draw_dots(twice, canvas, {.mean_coverage = 0.3}).radius, std::sqrt(0.3 * 1600 / kPi), 0.2);
}

TEST(DrawDots, DrawsPartsOfDotsCentredOutside) {
    const Point outside{-3, 20.3};
    const Canvas canvas{40, 40, 1};
    EXPECT_EQ(ink_of(draw_dots(std::span(&outside, 1), canvas, {.radius = 2.0})), 0);
    EXPECT_GT(ink_of(draw_dots(std::span(&outside, 1), canvas, {.radius = 6.0})), 0);
    EXPECT_NEAR(ink_of(draw_dots(std::span(&outside, 1), canvas, {.mean_coverage = 0.25})), 400, 1);
    const Point far{1e6, -1e6};
    EXPECT_EQ(ink_of(draw_dots(std::span(&far, 1), canvas, {.radius = 6.0})), 0);
}

TEST(DrawDots, ReachesAnyCoverageWithOneDot) {
    const Point dot{13.37, 22.11};
    for (const double wanted : {0.0, 0.001, 0.5, 0.99, 1.0}) {
        EXPECT_NEAR(ink_of(draw_dots(std::span(&dot, 1), {40, 30, 1}, {.mean_coverage = wanted})), wanted * 1200, 1);
    }
}

TEST(DrawDots, DrawsNothingWithoutDots) {
    for (const bool antialias : {false, true}) {
        const Raster raster = draw_dots({}, {8, 8, 1}, {.radius = 2.0, .antialias = antialias});
        EXPECT_EQ(ink_of(raster), 0);
    }
}

}  // namespace
}  // namespace ccdt

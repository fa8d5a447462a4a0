// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/coverage_curve.h"

#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/dots/dots.h"

namespace ccdt {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kSide = 64;

/// Returns the dots of a flat grey.
std::vector<Point> flat(std::size_t sites, Quality quality) {
    const auto density = Density::grid(1, 1, std::span<const float>(std::vector<float>{1})).value();
    const auto domain = Domain::rectangle(kSide, kSide).value();
    return distribute(domain, density, {.sites = sites, .seed = 3, .quality = quality}).value().points;
}

double mean(const Raster& raster) {
    return std::accumulate(raster.coverage.begin(), raster.coverage.end(), 0.0) / 255 /
           static_cast<double>(raster.coverage.size());
}

constexpr double kShares[] = {0.005, 0.1, 0.3, 0.5, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98, 0.995};

TEST(CoverageCurve, MatchesPolishedDots) {
    constexpr std::size_t kSites = 4096;
    constexpr double kScale = 16;
    const Canvas canvas{static_cast<int>(kScale * kSide), static_cast<int>(kScale * kSide), kScale};
    const CoverageCurve curve;
    for (const auto& [quality, tolerance] :
         {std::pair{Quality::Draft, 0.009}, {Quality::Standard, 0.003}, {Quality::Best, 0.005}}) {
        const std::vector<Point> dots = flat(kSites, quality);
        for (const double share : kShares) {
            const double radius = std::sqrt(curve.dots(share) / (kPi * kSites)) * kSide;
            EXPECT_NEAR(mean(draw_dots(dots, canvas, {.radius = kScale * radius})), share, tolerance) << share;
        }
    }
}

TEST(CoverageCurve, IsLinearWhereDotsDoNotOverlap) {
    for (const double share : {0.0, 0.001, 0.25, 0.6}) EXPECT_NEAR(CoverageCurve().dots(share), share, 1e-5);
}

TEST(CoverageCurve, IsMonotonic) {
    const CoverageCurve curve;
    for (int i = 0; i < 1000; ++i) EXPECT_LT(curve.dots(i / 1000.0), curve.dots((i + 1) / 1000.0)) << i;
    EXPECT_EQ(curve.dots(1.5), curve.dots(1));
    EXPECT_EQ(curve.dots(-1), 0);
}

TEST(CoverageCurve, EndsAtSolidCoverage) {
    EXPECT_GT(CoverageCurve().solid(), 0.9995);
    EXPECT_NEAR(CoverageCurve().dots(1), 1.6, 0.05) << "relative to the number of dots without overlaps";
}

/// Tests antialiased dots, and binary dots with several samples per pixel.
TEST(DrawDots, MatchesRasterizedDiscs) {
    const std::vector<Point> dots = flat(4096, Quality::Standard);
    for (const auto& [radius, samples] : {std::pair{6.0, 1}, {3.0, 1}, {1.0, 3}, {0.5, 6}}) {
        for (const double share : kShares) {
            const double scale = radius * std::sqrt(kPi * 4096 / CoverageCurve().dots(share)) / kSide;
            const int side = static_cast<int>(std::round(scale * kSide));
            for (const bool antialias : {false, true}) {
                if (!antialias && samples == 1) continue;
                const double fitting = radius * side / (scale * kSide);
                const DotOptions options{.radius = fitting, .antialias = antialias, .samples = samples};
                EXPECT_NEAR(mean(draw_dots(dots, {side, side, side / kSide}, options)), share, 0.005) << radius;
            }
        }
    }
}

}  // namespace
}  // namespace ccdt

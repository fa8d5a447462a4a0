// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/overprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/inks/separation.h"
#include "tests/support/inks.h"

namespace ccdt {
namespace {

using Channels = Overprint::Channels;

void expect_near(const Channels& light, const Channels& expected, double tolerance) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(light[c], expected[c], tolerance) << "channel " << c;
}

TEST(Overprint, ShowsPaperBetweenDotsOfOneInk) {
    const Overprint print({{{0.2f, 0.5f, 1}}, {1, 0.8f, 0.5f}, false});
    expect_near(print.light({0}), {1, 0.8, 0.5}, 1e-6);
    expect_near(print.light({0.25}), {0.8, 0.7, 0.5}, 1e-6);
    expect_near(print.light({1}), {0.2, 0.4, 0.5}, 1e-6);
}

TEST(Overprint, AddsAbsorptionOfSparseInksAndMultipliesDenseInks) {
    const Overprint print(test::cmyk_inks());
    expect_near(print.light({0.1, 0, 0, 0.1}), {0.8, 0.9, 0.9}, 1e-4);
    expect_near(print.light({0.99, 0.95, 0, 0}), {0.01, 0.05, 1}, 0.02);
    expect_near(print.light({0.97, 0.97, 0.97, 0.97}), {0.001, 0.001, 0.001}, 0.002);
}

TEST(Overprint, AddsLightOfLamps) {
    expect_near(Overprint(test::rgb_inks()).light({0.3, 1, 0}), {0.3, 1, 0}, 1e-3);
}

TEST(Overprint, HasNoNegativeLight) {
    const Overprint print(test::cmyk_inks());
    for (double a = 0; a <= 1; a += 0.1) {
        for (double b = 0; b <= 1; b += 0.1) {
            for (const double light : print.light({a, b, 1 - a, 0.5 * (a + b)}))
                EXPECT_GT(light, -0.01) << a << " " << b;
        }
    }
}

/// Returns the mean light of rasterized dots of a flat tint, with the same radius for all inks.
/// @param cover  [inks] coverage that the dots of each ink would have without the other inks
Channels dotted(const InkSet& inks, const std::vector<double>& cover) {
    constexpr std::size_t kSites = 6000;
    constexpr int kSide = 700;
    const CoverageCurve curve;
    std::vector<double> areas;
    for (const double share : cover) areas.push_back(curve.dots(share));
    double all = 0;
    for (const double area : areas) all += area;
    const double radius = kSide * std::sqrt(all / (3.14159265 * kSites));
    const std::vector<Density> densities(cover.size(), Density::uniform());
    const auto runs =
        distribute_inks(Domain::rectangle(1, 1).value(), densities, share_sites(areas, kSites), {.seed = 4}).value();
    std::vector<Raster> rasters;
    for (const Distribution& run : runs)
        rasters.push_back(draw_dots(run.points, {kSide, kSide, kSide}, {radius, 0, false, 1}));
    Channels sum{};
    for (std::size_t p = 0; p < rasters[0].coverage.size(); ++p) {
        std::vector<float> here;
        for (const Raster& raster : rasters) here.push_back(raster.coverage[p] > 0 ? 1 : 0);
        const Light light = printed(inks, here);
        sum = {sum[0] + light.red, sum[1] + light.green, sum[2] + light.blue};
    }
    for (double& channel : sum) channel /= static_cast<double>(rasters[0].coverage.size());
    return sum;
}

TEST(Overprint, MatchesRasterizedDots) {
    const InkSet inks = test::cmyk_inks();
    const Overprint print(inks);
    for (const std::array<double, 4>& cover : {std::array<double, 4>{0.2, 0, 0, 0.2},
                                               {0.3, 0.2, 0, 0.3},
                                               {0.2, 0.5, 0, 0.4},
                                               {0.7, 0, 0, 0.6},
                                               {0, 0.05, 0, 0.9},
                                               {0, 0.5, 0.7, 0.8},
                                               {0.9, 0.8, 0.3, 0.2},
                                               {0.3, 0.3, 0.3, 0.95}}) {
        SCOPED_TRACE(testing::PrintToString(cover));
        expect_near(dotted(inks, {cover.begin(), cover.end()}),
                    print.light({cover[0], cover[1], cover[2], cover[3], 0, 0}), 0.012);
    }
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/mass_samples.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/baselines/site_mesh.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;

std::vector<Point> samples_of(const Domain& domain, const Density& density, std::size_t count, std::uint64_t seed = 1) {
    const auto sites = SiteMesh::create(domain, density, {.sites = 100, .seed = seed}, {}).value();
    return mass_samples(domain, sites.mesh(), density, count, seed, {});
}

/// Returns the mean of (number - expected)^2 / expected over 8 x 8 cells of the unit square; 1 for independent samples.
template <class Expected>
double dispersion(const std::vector<Point>& samples, Expected&& expected) {
    std::vector<double> counts(64, 0);
    for (const Point& p : samples) {
        counts[static_cast<std::size_t>(8 * p.y) * 8 + static_cast<std::size_t>(8 * p.x)] += 1;
    }
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) sum += (counts[i] - expected(i)) * (counts[i] - expected(i)) / expected(i);
    return sum / 64;
}

TEST(MassSamples, AreSpreadEvenly) {
    const Domain square = Domain::rectangle(1, 1).value();
    for (const std::size_t count : {5000, 5001}) {
        const auto samples = samples_of(square, Density::uniform(), count);
        EXPECT_EQ(samples.size(), count);
        EXPECT_EQ(test::count_distinct(samples), count);
        EXPECT_LT(dispersion(samples, [&](std::size_t) { return static_cast<double>(count) / 64; }), 0.06);
    }
}

TEST(MassSamples, FollowTheDensity) {
    // The second density is the first one on a grid finer than the spacing of samples.
    for (const int cells : {8, 512}) {
        const Density ramp = grid_of(cells, cells, [&](int i, int) { return 8 * i / cells + 0.5; });
        for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
            const auto samples = samples_of(domain, ramp, 5000);
            EXPECT_EQ(samples.size(), 5000u);
            const auto expected = [](std::size_t i) { return 5000 * (2 * static_cast<double>(i % 8) + 1) / 512; };
            EXPECT_LT(dispersion(samples, expected), 0.1) << cells;
        }
    }
}

TEST(MassSamples, LieInThePolygon) {
    for (const test::Parts& parts :
         {test::Parts{{test::u_shape(), {}}}, test::Parts{test::sieve(4)}, test::read_geojson("Italy-110m.geojson")}) {
        const Domain domain = domain_of(parts);
        auto samples = samples_of(domain, Density::uniform(), 3000);
        EXPECT_EQ(samples.size(), 3000u);
        for (Point& p : samples) p = domain.to_user(p);
        EXPECT_EQ(test::count_outside(parts, samples), 0u);
    }
}

TEST(MassSamples, FindTheOnlyPixelWithDensity) {
    const Density pixel = grid_of(1000, 1000, [](int i, int j) { return i == 700 && j == 500 ? 1.0 : 0.0; });
    for (const Point& p : samples_of(Domain::rectangle(1, 1).value(), pixel, 1000)) {
        EXPECT_TRUE(p.x >= 0.7 && p.x <= 0.701 && p.y >= 0.5 && p.y <= 0.501) << p.x << " " << p.y;
    }
}

TEST(MassSamples, AvoidWhite) {
    const Density board = grid_of(16, 16, [](int i, int j) { return (i + j) % 2 == 0 ? 0.0 : 1.0; });
    for (const Point& p : samples_of(Domain::rectangle(1, 1).value(), board, 1000)) {
        EXPECT_EQ((static_cast<int>(16 * p.x) + static_cast<int>(16 * p.y)) % 2, 1);
    }
}

TEST(MassSamples, DependOnTheSeed) {
    const Domain square = Domain::rectangle(1, 1).value();
    const auto samples = samples_of(square, Density::uniform(), 1000);
    EXPECT_EQ(samples_of(square, Density::uniform(), 1000), samples);
    EXPECT_NE(samples_of(square, Density::uniform(), 1000, 2), samples);
}

TEST(MassSamples, StopOnRequest) {
    const Domain square = Domain::rectangle(1, 1).value();
    const auto sites = SiteMesh::create(square, Density::uniform(), {.sites = 10}, {}).value();
    std::stop_source stop;
    stop.request_stop();
    EXPECT_LT(mass_samples(square, sites.mesh(), Density::uniform(), 100'000, 1, stop.get_token()).size(), 10'000u);
}

}  // namespace
}  // namespace ccdt

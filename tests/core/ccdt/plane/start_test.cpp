// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/start.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::grid_of;

/// Returns the variance of the numbers of sites in 8 x 8 cells, divided by their mean; 1 for independent sites.
double dispersion(const Density& density, Start kind, std::size_t sites, std::uint64_t seed,
                  const std::vector<double>& expected) {
    const Domain domain = Domain::rectangle(1, 1).value();
    const StartSites start(domain, density, Options{.sites = sites, .seed = seed, .start = kind});
    std::vector<double> counts(64, 0);
    for (std::size_t i = 0; i < sites; ++i) {
        const Point p = start.draw(i, 0);
        counts[static_cast<std::size_t>(8 * p.y) * 8 + static_cast<std::size_t>(8 * p.x)] += 1;
    }
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) sum += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
    return sum / 63;
}

double mean_dispersion(const Density& density, Start kind, const std::vector<double>& expected) {
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) sum += dispersion(density, kind, 5000, seed, expected);
    return sum / 10;
}

const std::vector<double> kEven(64, 5000.0 / 64);

TEST(StartSites, SpreadEvenlyWhenStratified) {
    EXPECT_LT(mean_dispersion(Density::uniform(), Start::Stratified, kEven), 0.15);
}

TEST(StartSites, AreAPoissonProcessWhenRandom) {
    const double random = mean_dispersion(Density::uniform(), Start::Random, kEven);
    EXPECT_GT(random, 0.8);
    EXPECT_LT(random, 1.2);
}

TEST(StartSites, FollowTheDensity) {
    // Grids coarser and finer than the cells, and finer than the summation blocks.
    for (const int cells : {8, 64, 1024}) {
        const auto ramp = [&](int i, int) { return i + 0.5; };
        const Density density = grid_of(cells, cells, ramp);
        std::vector<double> expected(64);
        for (std::size_t i = 0; i < 64; ++i) expected[i] = 5000.0 * (2 * static_cast<double>(i % 8) + 1) / 512;
        EXPECT_LT(mean_dispersion(density, Start::Stratified, expected), 0.2) << cells;
        const double random = mean_dispersion(density, Start::Random, expected);
        EXPECT_GT(random, 0.75) << cells;
        EXPECT_LT(random, 1.25) << cells;
    }
}

TEST(StartSites, AvoidWhite) {
    const Density half = grid_of(16, 16, [](int i, int j) { return (i + j) % 2 == 0 ? 0.0 : 1.0; });
    const Domain domain = Domain::rectangle(1, 1).value();
    for (const Start kind : {Start::Stratified, Start::Random}) {
        const StartSites start(domain, half, Options{.sites = 1000, .seed = 3, .start = kind});
        for (std::size_t i = 0; i < 1000; ++i) {
            const Point p = start.draw(i, 0);
            EXPECT_EQ((static_cast<int>(16 * p.x) + static_cast<int>(16 * p.y)) % 2, 1);
        }
    }
}

TEST(StartSites, AvoidFineWhite) {
    // Lines of one pixel, thirty pixels apart, in a picture much finer than the spacing of sites.
    const Density lines = grid_of(1200, 1200, [](int i, int) { return i % 30 == 7 ? 1.0 : 0.0; });
    const Domain domain = Domain::rectangle(1, 1).value();
    for (const Start kind : {Start::Stratified, Start::Random}) {
        const StartSites start(domain, lines, Options{.sites = 1000, .seed = 3, .start = kind});
        int off = 0;
        for (std::size_t i = 0; i < 1000; ++i) off += static_cast<int>(1200 * start.draw(i, 0).x) % 30 == 7 ? 0 : 1;
        EXPECT_LT(off, 20);
    }
}

TEST(StartSites, StayInTheBox) {
    const Domain domain = domain_of(test::read_geojson("South-Africa-50m.geojson"));
    const Density uniform = Density::uniform();
    const StartSites start(domain, uniform, Options{.sites = 1000, .seed = 1});
    for (std::size_t i = 0; i < 1000; ++i) {
        const Point p = start.draw(i, static_cast<int>(i % 7));
        EXPECT_GE(p.x, 0);
        EXPECT_GE(p.y, 0);
        EXPECT_LE(p.x, domain.unit_bounds().max.x);
        EXPECT_LE(p.y, domain.unit_bounds().max.y);
    }
}

TEST(StartSites, DependOnSeedSiteAndAttemptOnly) {
    const Domain domain = Domain::rectangle(1, 1).value();
    const Density uniform = Density::uniform();
    const StartSites start(domain, uniform, Options{.sites = 100, .seed = 1});
    const StartSites same(domain, uniform, Options{.sites = 100, .seed = 1});
    const StartSites other(domain, uniform, Options{.sites = 100, .seed = 2});
    const Point p = start.draw(42, 3);
    start.draw(41, 0);
    EXPECT_EQ(start.draw(42, 3), p);
    EXPECT_EQ(same.draw(42, 3), p);
    EXPECT_NE(other.draw(42, 3), p);
    EXPECT_NE(start.draw(42, 4), p);
    EXPECT_NE(start.draw(43, 3), p);
}

}  // namespace
}  // namespace ccdt

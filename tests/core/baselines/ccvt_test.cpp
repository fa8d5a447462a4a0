// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/ccvt.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

TEST(Ccvt, EndsAtConvergence) {
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        const auto result = ccvt(domain, Density::uniform(), {.sites = 256, .seed = 1, .iterations = kCcvtIterations});
        EXPECT_GT(result->iterations, 5);
        EXPECT_LT(result->iterations, 300);
        EXPECT_FALSE(result->stopped);
        EXPECT_LT(result->variation(), 0.2);
        EXPECT_GT(result->trace.front(), 0.5);
    }
}

/// Returns the least distance on the unit torus, relative to that of the densest packing.
double least_distance(const std::vector<Point>& points) {
    double least = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Point way = points[i] - points[j];
            least = std::min(least, std::hypot(way.x - std::round(way.x), way.y - std::round(way.y)));
        }
    }
    return least / std::sqrt(2 / (std::sqrt(3.0) * static_cast<double>(points.size())));
}

/// Published implementations reach a least distance of 0.676, on average over sets of 1,024 sites.
TEST(Ccvt, ReachesThePublishedDistances) {
    double mean = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        const auto result = ccvt(Domain::torus(1, 1).value(), Density::uniform(),
                                 {.sites = 512, .seed = seed, .iterations = kCcvtIterations});
        mean += least_distance(result->points) / 4;
    }
    EXPECT_GT(mean, 0.64);
    EXPECT_LT(mean, 0.75);
}

TEST(Ccvt, PlacesASingleSiteAtTheCentroid) {
    const Domain triangle = test::domain_of({{{{0, 0}, {3, 0}, {0, 3}}, {}}});
    const Point p = ccvt(triangle, Density::uniform(), {.sites = 1, .iterations = kCcvtIterations})->points[0];
    EXPECT_NEAR(p.x, 1, 0.02);
    EXPECT_NEAR(p.y, 1, 0.02);
}

/// Each site represents the same capacity, so a strip of the domain has almost exactly its share of the sites.
TEST(Ccvt, GivesEachPartItsShare) {
    const Density steps = test::grid_of(4, 1, [](int i, int) { return 1.0 + i; });
    const auto points =
        ccvt(Domain::rectangle(1, 1).value(), steps, {.sites = 500, .seed = 2, .iterations = kCcvtIterations})->points;
    for (int quarter = 0; quarter < 4; ++quarter) {
        const auto count = std::ranges::count_if(points, [&](Point p) { return static_cast<int>(4 * p.x) == quarter; });
        EXPECT_NEAR(static_cast<double>(count), 50 * (quarter + 1), 8);
    }
}

}  // namespace
}  // namespace ccdt

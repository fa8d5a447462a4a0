// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/random_sites.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

/// Returns the variance of the numbers of points in 8 x 8 cells, divided by their mean; 1 for independent points.
double dispersion(const std::vector<Point>& points) {
    std::vector<double> counts(64, 0);
    for (const Point& p : points) {
        counts[static_cast<std::size_t>(8 * p.y) * 8 + static_cast<std::size_t>(8 * p.x)] += 1;
    }
    const double mean = static_cast<double>(points.size()) / 64;
    double sum = 0;
    for (const double count : counts) sum += (count - mean) * (count - mean) / mean;
    return sum / 63;
}

TEST(RandomSites, AreIndependent) {
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        double mean = 0;
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            mean += dispersion(random_sites(domain, Density::uniform(), {.sites = 3000, .seed = seed})->points) / 10;
        }
        EXPECT_GT(mean, 0.8);
        EXPECT_LT(mean, 1.2);
    }
}

TEST(RandomSites, HaveNoIterations) {
    const auto result = random_sites(Domain::rectangle(1, 1).value(), Density::uniform(), {.sites = 50});
    EXPECT_EQ(result->iterations, 0);
    EXPECT_EQ(result->trace.size(), 1u);
}

}  // namespace
}  // namespace ccdt

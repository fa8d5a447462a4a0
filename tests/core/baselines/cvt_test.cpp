// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/cvt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::grid_of;

constexpr int kCells = 300;

/// Calls visit(nearest site, vector from it, column, row) for each cell centre of a fine grid over the unit square.
template <class Visit>
void for_each_position(const std::vector<Point>& sites, bool around, Visit&& visit) {
    for (int j = 0; j < kCells; ++j) {
        for (int i = 0; i < kCells; ++i) {
            const Point position{(i + 0.5) / kCells, (j + 0.5) / kCells};
            std::size_t owner = 0;
            Point shortest;
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t s = 0; s < sites.size(); ++s) {
                Point way = position - sites[s];
                if (around) way = {way.x - std::round(way.x), way.y - std::round(way.y)};
                if (dot(way, way) >= least) continue;
                least = dot(way, way);
                owner = s;
                shortest = way;
            }
            visit(owner, shortest, i, j);
        }
    }
}

double energy(const std::vector<Point>& sites, bool around) {
    double sum = 0;
    for_each_position(sites, around, [&](std::size_t, Point way, int, int) { sum += dot(way, way); });
    return sum / (kCells * kCells);
}

TEST(Cvt, LowersTheEnergy) {
    for (const bool around : {false, true}) {
        const Domain domain = (around ? Domain::torus(1, 1) : Domain::rectangle(1, 1)).value();
        double before = std::numeric_limits<double>::infinity();
        for (const int iterations : {0, 1, 2, 4, 8, 16, 32}) {
            const auto result = cvt(domain, Density::uniform(), {.sites = 60, .seed = 1, .iterations = iterations});
            const double now = energy(result->points, around);
            EXPECT_LT(now, before) << iterations;
            before = now;
        }
        // The energy per area of a hexagonal grid is 5 / (18 sqrt 3) times the area of a cell.
        EXPECT_GT(before, 0.1603 / 60);
        EXPECT_LT(before, 0.1603 / 60 * 1.06);
    }
}

TEST(Cvt, MovesSitesToTheCentroidsOfTheirCells) {
    const Density ramp = grid_of(kCells, kCells, [](int i, int) { return 50.0 + i; });
    for (const bool around : {false, true}) {
        const Domain domain = (around ? Domain::torus(1, 1) : Domain::rectangle(1, 1)).value();
        const auto points = cvt(domain, ramp, {.sites = 40, .seed = 3, .iterations = 300})->points;
        std::vector<Point> moments(points.size());
        std::vector<double> masses(points.size(), 0);
        for_each_position(points, around, [&](std::size_t owner, Point way, int i, int j) {
            const double weight = ramp.value(i, j) * ramp.value(i, j);
            moments[owner] = moments[owner] + weight * way;
            masses[owner] += weight;
        });
        for (std::size_t s = 0; s < points.size(); ++s) {
            const Point off = 1 / masses[s] * moments[s];
            EXPECT_LT(std::sqrt(dot(off, off)), 0.006 / std::sqrt(40.0)) << s;
        }
    }
}

TEST(Cvt, PlacesASingleSiteAtTheCentroid) {
    const Domain triangle = test::domain_of({{{{0, 0}, {3, 0}, {0, 3}}, {}}});
    const Point p = cvt(triangle, Density::uniform(), {.sites = 1, .iterations = kCvtIterations})->points[0];
    EXPECT_NEAR(p.x, 1, 1e-12);
    EXPECT_NEAR(p.y, 1, 1e-12);
}

TEST(Cvt, Converges) {
    const auto result = cvt(Domain::rectangle(1, 1).value(), Density::uniform(), {.sites = 4, .iterations = 1000});
    EXPECT_LT(result->iterations, 1000);
}

TEST(Cvt, MakesTrianglesAlmostEqual) {
    const auto result =
        cvt(Domain::torus(1, 1).value(), Density::uniform(), {.sites = 400, .seed = 1, .iterations = kCvtIterations});
    EXPECT_GT(result->trace.front(), 0.5);
    EXPECT_LT(result->variation(), 0.1);
}

}  // namespace
}  // namespace ccdt

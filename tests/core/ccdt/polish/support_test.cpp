// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/support.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::count_on_white;
using test::grid_of;

const Domain kSquare = Domain::rectangle(1, 1).value();

/// Returns the distance from a grid point to the nearest cell with density, in cells.
double distance_to_density(const Density& density, Point g) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int j = 0; j < density.height(); ++j) {
        for (int i = 0; i < density.width(); ++i) {
            if (!(density.value(i, j) > 0)) continue;
            const Point q{std::clamp(g.x, i + 0.0, i + 1.0), std::clamp(g.y, j + 0.0, j + 1.0)};
            nearest = std::min(nearest, std::sqrt(dot(q - g, q - g)));
        }
    }
    return nearest;
}

TEST(Support, FindsDensityWithinReach) {
    constexpr double kReach = 0.2;
    const Domain domain = Domain::rectangle(2, 1).value();  // in the unit frame 1 x 0.5
    Random random(1, 0);
    int far = 0;
    for (const double share : {0.5, 0.02, 0.001}) {
        const Density density =
            grid_of(60, 30, [&](int i, int j) { return random.uniform() < share || i + j == 0 ? 1.0 : 0.0; });
        const Support support(domain, density);
        for (int k = 0; k < 2000; ++k) {
            const Point p{random.uniform(), 0.5 * random.uniform()}, g = 60 * p;
            const double distance = distance_to_density(density, g);
            const Point found = support.nearest(p, kReach), q = 60 * found;
            if (distance > kReach * 60) {
                ++far;
                if (found == p) continue;
            }
            ASSERT_EQ(count_on_white(domain, density, {2 * found}), 0u) << p.x << ' ' << p.y;
            // Cells are searched in squares, whose corners are farther away than their sides.
            ASSERT_LE(std::sqrt(dot(q - g, q - g)), std::sqrt(2.0) * distance + 0.2) << p.x << ' ' << p.y;
        }
    }
    EXPECT_GT(far, 0) << "some are out of reach";
}

TEST(Support, KeepsPointsWithDensity) {
    const Domain domain = kSquare;
    const Density density = grid_of(10, 10, [](int i, int) { return i < 5 ? 1.0 : 0.0; });
    const Support support(domain, density);
    EXPECT_EQ(support.nearest({0.25, 0.75}, 1), (Point{0.25, 0.75}));
    EXPECT_EQ(support.nearest({0.33, 0.05}, 1), (Point{0.33, 0.05}));
}

TEST(Support, LimitsTheSearchToTheReach) {
    const Density corner = grid_of(1000, 1000, [](int i, int j) { return i + j == 0 ? 1.0 : 0.0; });
    const Support support(kSquare, corner);
    EXPECT_EQ(support.nearest({0.9, 0.9}, 0.01), (Point{0.9, 0.9}));
    const Point found = support.nearest({0.9, 0.9}, 2);
    EXPECT_TRUE(found.x > 0 && found.x < 0.001 && found.y > 0 && found.y < 0.001) << found.x << ' ' << found.y;
}

}  // namespace
}  // namespace ccdt

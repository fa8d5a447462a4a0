// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/local_spacing.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::grid_of;

TEST(LocalSpacing, IsTheSpacingOfADenseCell) {
    const Density spot = grid_of(100, 50, [](int i, int j) { return i == 30 && j == 20 ? 4.0 : i == 31 ? 1.0 : 0.0; });
    const LocalSpacing spacing({1, 0.5}, spot, 54'000);
    EXPECT_NEAR(spacing.at({0.305, 0.205}), 0.01 / std::sqrt(4000), 1e-9);
    EXPECT_NEAR(spacing.at({0.311, 0.499}), 0.01 / std::sqrt(1000), 1e-9);
}

TEST(LocalSpacing, IsTheSpacingOfABlockWithOneSite) {
    const Density even = grid_of(64, 64, [](int, int) { return 1.0; });
    for (const double sites : {0.5, 1.0, 7.0, 1000.0, 1e6}) {
        EXPECT_NEAR(LocalSpacing({1, 1}, even, sites).at({0.3, 0.9}), 1 / std::sqrt(sites), 1e-6) << sites;
    }
    // Blocks of 5 x 3 cells at the far sides are cut off.
    const Density cut = grid_of(5, 3, [](int, int) { return 1.0; });
    for (const double sites : {1.0, 4.0, 15.0, 60.0}) {
        EXPECT_NEAR(LocalSpacing({5, 3}, cut, sites).at({4.5, 2.5}), std::sqrt(15 / sites), 1e-6) << sites;
    }
}

TEST(LocalSpacing, IsValidAtTheFarSides) {
    const Density even = grid_of(8, 8, [](int, int) { return 1.0; });
    EXPECT_NEAR(LocalSpacing({1, 1}, even, 6400).at({1, 1}), 1.0 / 80, 1e-6);
}

}  // namespace
}  // namespace ccdt

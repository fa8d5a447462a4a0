// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/printed_spot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ccdt {
namespace {

TEST(PrintedSpot, CoversTheAreaOfADisc) {
    for (const double diameter : {1.0, 1.25, std::numbers::sqrt2, 1.7, 2.0}) {
        const PrintedSpot spot(diameter);
        double area = 0;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) area += static_cast<double>(spot.share(PrintedSpot::bit(dx, dy)));
        }
        EXPECT_NEAR(area, std::numbers::pi / 4 * diameter * diameter, 1e-3) << diameter;
    }
}

TEST(PrintedSpot, LeavesGapsBetweenSmallSpotsOnly) {
    EXPECT_NEAR(PrintedSpot(1).solid(), std::numbers::pi / 4, 1e-3);
    EXPECT_LT(PrintedSpot(1.4).solid(), 1);
    EXPECT_EQ(PrintedSpot(1.42).solid(), 1);
}

TEST(PrintedSpot, CountsOverlapsOnce) {
    const PrintedSpot spot(1.5);
    const auto left = PrintedSpot::bit(-1, 0), above = PrintedSpot::bit(0, -1), right = PrintedSpot::bit(1, 0);
    EXPECT_NEAR(spot.share(left | right), spot.share(left) + spot.share(right), 1e-6);
    EXPECT_LT(spot.share(left | above), spot.share(left) + spot.share(above) - 0.001f);
}

TEST(PrintedSpot, CoversNothingOutsideThePicture) {
    const PrintedSpot spot(2);
    for (PrintedSpot::Neighbourhood dark = 0; dark < PrintedSpot::kOutside; ++dark)
        ASSERT_EQ(spot.share(PrintedSpot::kOutside | dark), 0);
}

}  // namespace
}  // namespace ccdt

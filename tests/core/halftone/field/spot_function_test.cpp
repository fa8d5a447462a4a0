// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/spot_function.h"

#include <utility>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

/// Calls function(a, b, c) for the barycentric coordinates of the centres of small triangles of equal area.
template <class Function>
void for_positions(const Function& function) {
    constexpr int kSide = 300;
    for (int i = 0; i < kSide; ++i) {
        for (int j = 0; i + j < kSide; ++j) {
            for (const float third : {1 / 3.0f, 2 / 3.0f}) {
                const float b = (static_cast<float>(i) + third) / kSide, c = (static_cast<float>(j) + third) / kSide;
                if (b + c < 1) function(1 - b - c, b, c);
            }
        }
    }
}

TEST(SpotFunction, CoversEachShareOfATriangle) {
    const SpotFunction spots;
    for (const float share : {0.01f, 0.1f, 0.3f, 0.45f, 0.5f, 0.55f, 0.6f, 0.75f, 0.9f, 0.99f}) {
        double covered = 0, all = 0;
        for_positions([&](float a, float b, float c) {
            ++all;
            if (spots(a, b, c) > 1 - share) ++covered;
        });
        EXPECT_NEAR(covered / all, share, 1e-3);
    }
}

TEST(SpotFunction, IsTheSameForAllCorners) {
    const SpotFunction spots;
    EXPECT_EQ(spots(1, 0, 0), 1);
    EXPECT_NEAR(spots(1 / 3.0f, 1 / 3.0f, 1 / 3.0f), 0, 1e-6);
    EXPECT_EQ(spots(0.5f, 0.3f, 0.2f), spots(0.2f, 0.5f, 0.3f));
    EXPECT_EQ(spots(0.5f, 0.3f, 0.2f), spots(0.3f, 0.2f, 0.5f));
    EXPECT_NEAR(spots(0.5f, 0.5f, 0), 0.407f, 1e-3);  // where dots join
}

TEST(SpotFunction, MakesSmallDotsAndHolesRound) {
    const SpotFunction spots;
    // Places on circles around a corner and around the centroid of an equilateral triangle.
    constexpr double kHeight = 0.8660254037844386, kRadius = 0.08;
    const auto at = [&](double x, double y) {
        const double c = y / kHeight, b = x - c / 2;
        return spots(static_cast<float>(1 - b - c), static_cast<float>(b), static_cast<float>(c));
    };
    const float dot = at(kRadius, 0), hole = at(0.5 + kRadius, kHeight / 3);
    for (const auto& [x, y] : {std::pair(0.5, 0.8660254), {0.8660254, 0.5}, {0.9659258, 0.2588190}})
        EXPECT_NEAR(at(kRadius * x, kRadius * y), dot, 0.002);
    for (const auto& [x, y] : {std::pair(0.5, 0.8660254), {0.0, 1.0}, {-0.8660254, -0.5}, {0.0, -1.0}})
        EXPECT_NEAR(at(0.5 + kRadius * x, kHeight / 3 + kRadius * y), hole, 0.01);
}

}  // namespace
}  // namespace ccdt

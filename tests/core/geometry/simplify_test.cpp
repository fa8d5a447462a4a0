// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/simplify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ccdt {
namespace {

/// Returns a circle with every other corner slightly farther out.
Ring jagged_circle(int corners, double depth) {
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners, radius = 1 + (i % 2 == 1 ? depth : 0);
        ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    return ring;
}

TEST(Simplified, RemovesDetailFinerThanTheDistance) {
    const Ring ring = jagged_circle(10'000, 1e-4);
    const Ring coarse = simplified(ring, 1e-3);
    EXPECT_LT(coarse.size(), 300U);
    EXPECT_GT(coarse.size(), 40U);
    for (std::size_t i = 0; i < coarse.size(); ++i) {
        const Point middle = 0.5 * (coarse[i] + coarse[(i + 1) % coarse.size()]);
        EXPECT_NEAR(std::sqrt(dot(middle, middle)), 1, 1.2e-3);
    }
}

TEST(Simplified, KeepsCoarserDetail) {
    const Ring ring = jagged_circle(1000, 1e-1);
    EXPECT_EQ(simplified(ring, 1e-3), ring);
}

TEST(Simplified, KeepsARingThatWouldVanish) {
    const Ring ring = jagged_circle(100, 0);
    EXPECT_EQ(simplified(ring, 10), ring);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/predicates.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

TEST(Orientation, HasTheSignOfTheTurn) {
    EXPECT_EQ(orientation({0, 0}, {1, 0}, {0, 1}), 1);
    EXPECT_EQ(orientation({0, 0}, {0, 1}, {1, 0}), -1);
    EXPECT_EQ(orientation({0, 0}, {1, 1}, {3, 3}), 0);
}

TEST(Orientation, ResolvesOneUnitInTheLastPlace) {
    const Point a{12, 12}, b{24, 24};
    const double up = std::nextafter(0.5, 1.0);
    EXPECT_EQ(orientation(a, b, {0.5, 0.5}), 0);
    EXPECT_EQ(orientation(a, b, {0.5, up}), 1);
    EXPECT_EQ(orientation(a, b, {up, 0.5}), -1);
}

TEST(Orientation, IsExactAndAntisymmetricNearALine) {
    Random random(1, 0);
    for (int i = 0; i < 20000; ++i) {
        const Point a{random.uniform(), random.uniform()}, b{random.uniform(), random.uniform()};
        const double t = 3 * random.uniform() - 1;
        const Point c = a + t * (b - a);
        const int exact = exact_orientation(a, b, c);
        ASSERT_EQ(orientation(a, b, c), exact);
        ASSERT_EQ(orientation(b, c, a), exact);
        ASSERT_EQ(orientation(b, a, c), -exact);
    }
}

TEST(InCircle, DistinguishesInsideFromOutside) {
    const Point a{1, 0}, b{0, 1}, c{-1, 0};
    EXPECT_TRUE(in_circle(a, b, c, {0, 0}));
    EXPECT_FALSE(in_circle(a, b, c, {0, -2}));
    EXPECT_FALSE(in_circle(a, b, c, {0, -1})) << "on the circle is not inside";
    EXPECT_TRUE(in_circle(a, b, c, {0, std::nextafter(-1.0, 0.0)}));
    EXPECT_FALSE(in_circle(a, b, c, {0, std::nextafter(-1.0, -2.0)}));
}

TEST(InCircle, IsExactNearTheCircle) {
    Random random(2, 0);
    const auto on_circle = [&] {
        const double angle = 6.283185307179586 * random.uniform();
        return Point{0.5 + 0.3 * std::cos(angle), 0.5 + 0.3 * std::sin(angle)};
    };
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
        Point a = on_circle(), b = on_circle();
        const Point c = on_circle(), d = on_circle();
        if (orientation(a, b, c) < 0) std::swap(a, b);
        const bool exact = exact_in_circle(a, b, c, d) > 0;
        ASSERT_EQ(in_circle(a, b, c, d), exact);
        inside += exact ? 1 : 0;
    }
    EXPECT_GT(inside, 1000);
    EXPECT_LT(inside, 4000);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/inside.h"

#include <gtest/gtest.h>

namespace ccdt {
namespace {

const std::vector<Ring> kRings = {{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}, {{1, 0.25}, {1, 0.5}, {3, 0.5}, {3, 0.25}}};

TEST(Inside, DistinguishesInsideFromOutside) {
    const Inside inside(kRings);
    for (const Point p : {Point{0.5, 0.5}, Point{3.9, 3.5}, Point{2, 0.75}, Point{2, 0.1}})
        EXPECT_TRUE(inside.contains(p));
    for (const Point p :
         {Point{2, 2}, Point{2, 0.4}, Point{-1, 1}, Point{5, 1}, Point{2, 0}, Point{2, 1}, Point{2, -1}})
        EXPECT_FALSE(inside.contains(p)) << p.x << ' ' << p.y;
}

TEST(Inside, MovesPointsOutsideToTheInside) {
    const Inside inside(kRings);
    EXPECT_EQ(inside.nearest({0.5, 0.5}, 1), (Point{0.5, 0.5}));
    for (const Point p :
         {Point{2, -1e-5}, Point{2, 0}, Point{4, 4.001}, Point{2, 1.001}, Point{0, 0}, Point{1.001, 0.4}}) {
        const Point there = inside.nearest(p, 0.5);
        EXPECT_TRUE(inside.contains(there)) << p.x << ' ' << p.y;
        EXPECT_LT(dot(there - p, there - p), 1e-4);
    }
}

}  // namespace
}  // namespace ccdt

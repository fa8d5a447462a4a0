// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/level_outline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/halftone/dots/ring_reduction.h"

namespace ccdt {
namespace {

constexpr CellGrid kCells = {48, 32};
constexpr Box kBox{{0, 0}, {48, 32}};

std::vector<float> cells(const auto& value) {
    std::vector<float> values;
    for (int y = 0; y < kCells.rows; ++y) {
        for (int x = 0; x < kCells.columns; ++x) values.push_back(static_cast<float>(value(x + 0.5, y + 0.5)));
    }
    return values;
}

double area(const std::vector<Point>& ring) {
    double twice = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) twice += cross(ring[i], ring[(i + 1) % ring.size()]);
    return twice / 2;
}

double area(const std::vector<std::vector<Point>>& rings) {
    double sum = 0;
    for (const auto& ring : rings) sum += area(ring);
    return std::abs(sum);
}

/// Returns the level of a disc around (20, 15).
double disc(double x, double y) {
    return (std::hypot(x - 20, y - 15) - 9) / 2;
}

TEST(LevelOutline, EnclosesTheAreaAtMostZero) {
    const double all = kCells.columns * kCells.rows, inside = std::acos(-1.0) * 81;
    EXPECT_NEAR(area(outline_of(cells(disc), kCells)), inside, 1);
    EXPECT_NEAR(area(outline_of(cells([](double x, double y) { return -disc(x, y); }), kCells)), all - inside, 1);
    EXPECT_DOUBLE_EQ(area(outline_of(cells([](double, double) { return -1; }), kCells)), all);
    EXPECT_TRUE(outline_of(cells([](double, double) { return 1; }), kCells).empty());
    EXPECT_DOUBLE_EQ(area(outline_of(std::vector{-1.0F}, {1, 1})), 1);
}

TEST(LevelOutline, SeparatesRingsThatTouchAtCorners) {
    Random random(9, 0);
    const auto rings = outline_of(cells([&](double, double) { return random.uniform() - 0.5; }), kCells);
    EXPECT_GT(rings.size(), 20U);
    EXPECT_NEAR(area(rings), kCells.columns * kCells.rows / 2.0, 60);
    for (const auto& ring : rings) {
        EXPECT_GE(ring.size(), 3U);
        for (const Point& p : ring) EXPECT_TRUE(p.x >= 0 && p.x <= kCells.columns && p.y >= 0 && p.y <= kCells.rows);
    }
}

TEST(LevelOutline, HasSharesOfTheSameArea) {
    Random random(4, 0);
    for (const float least : {-1.0F, -0.9F, -0.5F, -0.1F, -0.02F}) {
        const auto level = cells([&](double, double) { return least + random.uniform(); });
        const auto shares = outlined_shares(level, kCells);
        const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
        EXPECT_NEAR(sum, area(outline_of(level, kCells)), 1e-3 + 0.02 * sum)
            << least;  // squares at the border are halves
    }
}

TEST(RingReduction, KeepsTheAreaWithFewerCorners) {
    const auto circle = outline_of(cells(disc), kCells).at(0);
    for (const double displacement : {0.01, 0.1, 1.0, 20.0}) {
        const auto reduced = reduced_ring(circle, displacement, kBox);
        EXPECT_NEAR(area(reduced), area(circle), 1e-9 * std::abs(area(circle)));
        EXPECT_LT(reduced.size(), circle.size());
        for (const Point& p : reduced)
            EXPECT_NEAR(std::hypot(p.x - 20, p.y - 15), 9, 0.3 + std::sqrt(displacement) / 2);
    }
    EXPECT_LT(reduced_ring(circle, 1, kBox).size(), 14U);
}

TEST(RingReduction, KeepsCornersOnTheSidesOfTheBox) {
    Random random(3, 0);
    const auto rings = outline_of(cells([&](double, double) { return random.uniform() - 0.6; }), kCells);
    for (const auto& ring : rings) {
        const auto on_side = [](Point p) { return p.x <= 0 || p.y <= 0 || p.x >= 48 || p.y >= 32; };
        const auto reduced = reduced_ring(ring, 0.5, kBox);
        EXPECT_EQ(reduced.empty(), std::abs(area(ring)) < 0.005) << "a speck";
        if (reduced.empty()) continue;
        EXPECT_NEAR(area(reduced), area(ring), 1e-9 * std::max(1.0, std::abs(area(ring))));
        EXPECT_EQ(std::ranges::count_if(reduced, on_side), std::ranges::count_if(ring, on_side));
        EXPECT_GE(reduced.size(), 3U);
    }
}

}  // namespace
}  // namespace ccdt

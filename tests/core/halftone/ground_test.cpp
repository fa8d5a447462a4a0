// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/halftone/ground_outline.h"
#include "core/random.h"

namespace ccdt {
namespace {

constexpr CellGrid kCells = {48, 32};

std::vector<float> cells(const auto& value) {
    std::vector<float> values;
    for (int y = 0; y < kCells.rows; ++y) {
        for (int x = 0; x < kCells.columns; ++x) values.push_back(static_cast<float>(value(x + 0.5, y + 0.5)));
    }
    return values;
}

double area(const std::vector<Point>& ring) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        sum += (a.x * b.y - a.y * b.x) / 2;
    }
    return sum;
}

double black_area(const Ground& ground) {
    double sum = 0;
    for (const auto& ring : outline_of(ground)) sum += area(ring);
    return std::abs(sum);
}

/// Returns the level of a disc around (20, 15): 1 inside, falling to 0 within two cells.
double disc(double x, double y) {
    return std::clamp((9 - std::hypot(x - 20, y - 15)) / 2 + 0.5, 0.0, 1.0);
}

TEST(Ground, PlacesBoundaryWithSubcellPrecision) {
    const Ground ground(cells(disc), kCells);
    for (int k = 0; k < 360; k += 7) {
        const Point way{std::cos(k * 0.0174533), std::sin(k * 0.0174533)};
        EXPECT_TRUE(ground.is_white(Point{20, 15} + 8.9 * way)) << k;
        EXPECT_FALSE(ground.is_white(Point{20, 15} + 9.1 * way)) << k;
    }
    const auto shares = ground.white_shares(kCells);
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), std::acos(-1.0) * 81, 2);
}

TEST(Ground, TurnsFlippedPixelsIntoInk) {
    const Ground ground(cells(disc), kCells);
    for (const bool antialias : {false, true}) {
        Raster flips{kCells.columns * 4, kCells.rows * 4, 0, {}};
        flips.coverage.assign(std::size_t{kCells.columns} * kCells.rows * 16, 0);
        flips.coverage[0] = 255;
        ground.apply(flips, {4, 4}, antialias);
        EXPECT_EQ(flips.coverage[0], 0) << "a flipped pixel on black ground is white";
        EXPECT_EQ(flips.coverage[1], 255);
        const double black = std::accumulate(flips.coverage.begin(), flips.coverage.end(), 0.0) / 255 / 16;
        EXPECT_NEAR(black, kCells.columns * kCells.rows - std::acos(-1.0) * 81, 2);
        const bool has_greys =
            std::ranges::any_of(flips.coverage, [](std::uint8_t ink) { return ink != 0 && ink != 255; });
        EXPECT_EQ(has_greys, antialias);
    }
}

Ground divide(const std::vector<float>& light, const CellGrid& cells, double radius, double detail) {
    return divide_ground({&light, 1}, cells, radius, detail, false).front();
}

TEST(Ground, DividesNoisyRampWithoutIslands) {
    Random random(1, 0);
    const auto ramp = cells([&](double x, double) { return x / kCells.columns + 0.12 * (random.uniform() - 0.5); });
    const Ground ground = divide(ramp, kCells, 3, 0);
    EXPECT_EQ(outline_of(ground).size(), 1U) << "noise must not cause islands";
    for (const double y : {4.5, 16.5, 27.5}) {
        EXPECT_FALSE(ground.is_white({kCells.columns * 0.42, y}));
        EXPECT_TRUE(ground.is_white({kCells.columns * 0.58, y}));
    }
}

TEST(Ground, KeepsThinStrokesIfDetailIsRequested) {
    // A grey stroke two cells wide on light paper, as in small text.
    const auto stroke = cells([](double x, double) { return std::abs(x - 24) < 1 ? 0.45 : 0.85; });
    EXPECT_TRUE(divide(stroke, kCells, 1, 0).is_white({24, 16}));
    EXPECT_FALSE(divide(stroke, kCells, 1, 1).is_white({24, 16}));
}

TEST(Ground, IsThresholdedPictureForZeroRadius) {
    Random random(2, 0);
    const auto noise = cells([&](double, double) { return random.uniform() < 0.5 ? 0.0 : 1.0; });
    for (const double radius : {0.0, 5e-324}) {
        const Ground ground = divide(noise, kCells, radius, 1);
        for (int y = 0; y < kCells.rows; ++y) {
            for (int x = 0; x < kCells.columns; ++x) {
                const auto cell = static_cast<std::size_t>(y * kCells.columns + x);
                ASSERT_EQ(ground.is_white({x + 0.5, y + 0.5}), noise[cell] == 1) << x << ' ' << y;
            }
        }
    }
}

TEST(GroundOutline, EnclosesBlackGround) {
    const double all = kCells.columns * kCells.rows;
    EXPECT_NEAR(black_area(Ground(cells(disc), kCells)), all - std::acos(-1.0) * 81, 1);
    EXPECT_NEAR(black_area(Ground(cells([](double x, double y) { return 1 - disc(x, y); }), kCells)),
                std::acos(-1.0) * 81, 1);
    EXPECT_DOUBLE_EQ(black_area(Ground(cells([](double, double) { return 0; }), kCells)), all);
    EXPECT_TRUE(outline_of(Ground(cells([](double, double) { return 1; }), kCells)).empty());
}

TEST(GroundOutline, SeparatesRingsThatTouchAtCorners) {
    Random random(9, 0);
    const Ground ground(cells([&](double, double) { return random.uniform(); }), kCells);
    const auto rings = outline_of(ground);
    EXPECT_GT(rings.size(), 20U);
    const auto shares = ground.white_shares(kCells);
    const double white = std::accumulate(shares.begin(), shares.end(), 0.0);
    EXPECT_NEAR(black_area(ground), kCells.columns * kCells.rows - white, 0.03 * white);
    for (const auto& ring : rings) {
        EXPECT_GE(ring.size(), 3U);
        for (const Point& p : ring) {
            EXPECT_TRUE(p.x >= 0 && p.x <= kCells.columns && p.y >= 0 && p.y <= kCells.rows);
        }
    }
}

TEST(GroundOutline, AcceptsSingleCell) {
    EXPECT_DOUBLE_EQ(std::abs(area(outline_of(Ground({0.0F}, {1, 1})).at(0))), 1);
}

}  // namespace
}  // namespace ccdt

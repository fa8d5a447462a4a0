// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/spacing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

/// Computes the spacing from all pairs of points.
Spacing by_hand(const std::vector<Point>& points, Point sides, bool periodic) {
    Spacing spacing{std::numeric_limits<double>::infinity(), 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < points.size(); ++j) {
            if (i == j) continue;
            double dx = std::abs(points[i].x - points[j].x), dy = std::abs(points[i].y - points[j].y);
            if (periodic) {
                dx = std::min(dx, sides.x - dx);
                dy = std::min(dy, sides.y - dy);
            }
            nearest = std::min(nearest, std::hypot(dx, dy));
        }
        spacing.min = std::min(spacing.min, nearest);
        spacing.mean += nearest / static_cast<double>(points.size());
    }
    return spacing;
}

void expect_right(const std::vector<Point>& points, Point sides) {
    for (const bool periodic : {false, true}) {
        const Spacing expected = by_hand(points, sides, periodic);
        const Spacing found = measure_spacing(points, sides, periodic, {});
        EXPECT_NEAR(found.min, expected.min, 1e-12 * sides.x) << periodic << ' ' << points.size();
        EXPECT_NEAR(found.mean, expected.mean, 1e-12 * sides.x) << periodic << ' ' << points.size();
    }
}

/// @param power  1: uniform; a larger power crowds points towards the origin
std::vector<Point> noise(std::size_t count, Point sides, double power, std::uint64_t seed) {
    Random random(seed, 0);
    std::vector<Point> points(count);
    for (Point& p : points) {
        p = {sides.x * std::pow(random.uniform(), power), sides.y * std::pow(random.uniform(), power)};
    }
    return points;
}

TEST(Spacing, EqualsTheMinimumOverAllPairs) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        for (const std::size_t count : {2, 3, 5, 17, 100, 300}) {
            expect_right(noise(count, {1, 1}, 1, seed), {1, 1});
            expect_right(noise(count, {5, 0.2}, 1, seed), {5, 0.2});
            expect_right(noise(count, {0.01, 100}, 1, seed), {0.01, 100});
        }
    }
}

TEST(Spacing, EqualsTheMinimumOverAllPairsInCrowds) {
    expect_right(noise(300, {1, 1}, 8, 1), {1, 1});
    auto points = noise(200, {1e-6, 1e-6}, 1, 2);
    points.push_back({0.9, 0.95});
    expect_right(points, {1, 1});
}

TEST(Spacing, MeasuresAcrossTheBorderOfATorus) {
    const std::vector<Point> points = {{0.05, 0.5}, {2.95, 0.5}};
    EXPECT_NEAR(measure_spacing(points, {3, 1}, true, {}).min, 0.1, 1e-15);
    EXPECT_NEAR(measure_spacing(points, {3, 1}, false, {}).min, 2.9, 1e-15);
}

TEST(Spacing, AcceptsPointsOnTheBorder) {
    expect_right({{0, 0}, {1, 1}, {1, 0}, {0.5, 1}}, {1, 1});
}

TEST(Spacing, IsZeroForCoincidentPoints) {
    const std::vector<Point> points = {{0.3, 0.3}, {0.3, 0.3}, {0.3, 0.8}};
    const Spacing spacing = measure_spacing(points, {1, 1}, false, {});
    EXPECT_EQ(spacing.min, 0);
    EXPECT_DOUBLE_EQ(spacing.mean, 0.5 / 3);
}

TEST(Spacing, AcceptsManyCoincidentOrCollinearPoints) {
    // Comparing all pairs would take minutes.
    std::vector<Point> points(200'000, Point{0.5, 0.5});
    EXPECT_EQ(measure_spacing(points, {1, 1}, true, {}).mean, 0);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].y = 0.25 + 0x1p-30 * static_cast<double>(i);
    const Spacing spacing = measure_spacing(points, {1, 1}, true, {});
    EXPECT_EQ(spacing.min, 0x1p-30);
    EXPECT_EQ(spacing.mean, 0x1p-30);
}

TEST(Spacing, EqualsTheMinimumOverAllPairsInSpace) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for (const Point3 sides : {Point3{1, 1, 1}, Point3{3, 0.1, 0.5}}) {
        Random random(3, 0);
        std::vector<Point3> points(200);
        for (Point3& p : points)
            p = {sides.x * random.uniform(), sides.y * random.uniform(), sides.z * random.uniform()};
        for (const bool periodic : {false, true}) {
            double least = kFar, sum = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                double nearest = kFar;
                for (std::size_t j = 0; j < points.size(); ++j) {
                    Point3 apart = points[i] - points[j];
                    const auto around = [&](double v, double side) {
                        return periodic ? v - side * std::round(v / side) : v;
                    };
                    apart = {around(apart.x, sides.x), around(apart.y, sides.y), around(apart.z, sides.z)};
                    if (i != j) nearest = std::min(nearest, length(apart));
                }
                least = std::min(least, nearest);
                sum += nearest;
            }
            const Spacing found = measure_spacing(points, sides, periodic, {});
            EXPECT_NEAR(found.min, least, 1e-12);
            EXPECT_NEAR(found.mean, sum / 200, 1e-12);
        }
    }
}

}  // namespace
}  // namespace ccdt

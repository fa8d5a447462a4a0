// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/plane/fixed_area.h"
#include "core/geometry/hexagonal_spacing.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;

Domain square() {
    return Domain::rectangle(1, 1).value();
}

std::vector<Point> drawn(std::size_t count, Point corner = {0, 0}, double side = 1) {
    Random random(7, 0);
    std::vector<Point> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = random.uniform();
        points.push_back(corner + side * Point{x, random.uniform()});
    }
    return points;
}

std::vector<Point> position(const Domain& domain, std::size_t sites, const std::vector<Point>& fixed,
                            const Density& density = Density::uniform(), Quality quality = Quality::Standard) {
    Options options;
    options.sites = sites;
    options.fixed = fixed;
    options.quality = quality;
    const auto placed = distribute(domain, density, options);
    EXPECT_TRUE(placed) << placed.error().message;
    EXPECT_EQ(placed->points.size(), sites);
    EXPECT_EQ(test::count_distinct(placed->points), sites);
    return placed->points;
}

/// Returns the distances from points to the nearest of other points, in ascending order.
std::vector<double> distances(const std::vector<Point>& points, const std::vector<Point>& others, bool torus = false) {
    std::vector<double> nearest;
    for (const Point& p : points) {
        double least = std::numeric_limits<double>::max();
        for (const Point& q : others) {
            Point off = p - q;
            if (torus) off = {std::remainder(off.x, 1), std::remainder(off.y, 1)};
            if (dot(off, off) > 0) least = std::min(least, dot(off, off));
        }
        nearest.push_back(std::sqrt(least));
    }
    std::ranges::sort(nearest);
    return nearest;
}

FixedArea area_of(const std::vector<Point>& fixed, std::size_t sites) {
    constexpr int kSide = 256;
    std::vector<double> masses(kSide * kSide, 1);
    return subtract_fixed_area(square(), fixed, sites, kSide, kSide, masses);
}

TEST(FixedArea, IsTheAreaOfASiteForAnIsolatedPoint) {
    EXPECT_NEAR(area_of({{0.5, 0.5}}, 100).sites, 101, 0.1);
    EXPECT_NEAR(area_of({{0.2, 0.3}, {0.8, 0.9}}, 100).sites, 102, 0.2);
    EXPECT_NEAR(area_of({{0.2, 0.3}, {0.8, 0.9}}, 100).weights[1], 1, 0.1);
}

TEST(FixedArea, CountsCoincidentPointsOnce) {
    EXPECT_NEAR(area_of(std::vector<Point>(1000, {0.5, 0.5}), 100).sites, 101, 0.1);
}

TEST(FixedArea, IsTheAreaOfAClusterPlusARim) {
    // The points fill a square of side 0.1. The rim is the radius of a disc with the area of a site.
    const double sites = 10'000, rim = std::sqrt(1 / (sites * std::acos(-1)));
    const double area = 0.01 + 0.4 * rim;
    const double found = area_of(drawn(20'000, {0.4, 0.4}, 0.1), 10'000).sites;
    EXPECT_NEAR(found, sites / (1 - area), 0.003 * sites);
}

TEST(FixedArea, IncludesDiscsOfPointsOutside) {
    const double sites = area_of({{-0.02, 0.5}}, 100).sites;
    EXPECT_GT(sites, 100.1);
    EXPECT_LT(sites, 100.5);
    EXPECT_NEAR(area_of({{-0.2, 0.5}}, 100).sites, 100, 1e-6);
}

TEST(Fixed, KeepTheirDistanceFromSites) {
    const Domain torus = Domain::torus(1, 1).value();
    const Domain polygon =
        Domain::create({{{{0, 0}, {1, 0}, {1, 1}, {0.5, 0.4}, {0, 1}}, {box(0.2, 0.2, 0.1, 0.1)}}}).value();
    const std::vector<Point> fixed = drawn(60);
    for (const Domain& domain : {square(), torus, polygon}) {
        const double hexagonal = hexagonal_spacing(1060 / domain.area());
        const auto points = position(domain, 1000, fixed);
        const auto to_fixed = distances(points, fixed, domain.is_torus());
        EXPECT_GT(to_fixed.front(), 0.7 * hexagonal);
        EXPECT_GT(distances(points, points, domain.is_torus()).front(), 0.7 * hexagonal);
        // No hole is left around the fixed points either.
        const auto from_fixed = distances(fixed, points, domain.is_torus());
        EXPECT_LT(from_fixed[from_fixed.size() / 2], 1.1 * hexagonal);
    }
}

TEST(Fixed, CanBeClusteredAndCoincident) {
    std::vector<Point> fixed = drawn(300, {0.45, 0.45}, 0.1);
    fixed.insert(fixed.end(), 50, {0.2, 0.2});
    for (int i = 0; i < 100; ++i) fixed.push_back({0.8 + 1e-9 * i, 0.8});
    for (const Domain& domain : {square(), Domain::torus(1, 1).value()}) {
        const auto points = position(domain, 1000, fixed);
        const double hexagonal = hexagonal_spacing(1010);
        EXPECT_GT(distances(points, fixed, domain.is_torus()).front(), 0.7 * hexagonal);
        // Coincident points attract or repel no more sites than a single point, which has about six neighbours.
        for (const Point& copies : {Point{0.2, 0.2}, Point{0.8, 0.8}}) {
            const auto near = std::ranges::count_if(
                points, [&](const Point& p) { return std::sqrt(dot(p - copies, p - copies)) < 1.5 * hexagonal; });
            EXPECT_GE(near, 5);
            EXPECT_LE(near, 8);
        }
    }
}

TEST(Fixed, LeaveTheOtherSitesEven) {
    // The fixed points fill a sixteenth of the square, in the right half. The rest of the square is evenly dense.
    const std::vector<Point> fixed = drawn(5000, {0.5, 0}, 0.25);
    const auto points = position(square(), 4000, fixed);
    const auto left = std::ranges::count_if(points, [](const Point& p) { return p.x < 0.5; });
    EXPECT_NEAR(static_cast<double>(left) / 4000, 0.5 / (1 - 0.0625), 0.01);
}

TEST(Fixed, CanOutnumberTheSites) {
    std::vector<Point> fixed;
    constexpr int kSide = 30;
    for (int i = 0; i < kSide * kSide; ++i) fixed.push_back({(i % kSide + 0.5) / kSide, (i / kSide + 0.5) / kSide});
    // No place is farther from all points of a square lattice than the centre of a square.
    for (const std::size_t sites : {1, 10}) {
        EXPECT_GT(distances(position(square(), sites, fixed), fixed).front(), 0.85 * std::sqrt(0.5) / kSide);
    }
}

TEST(Fixed, TakeAreaByTheDensity) {
    const std::vector<double> values = {1, 4};
    const auto density = Density::grid(2, 1, values).value();
    const std::vector<Point> fixed = drawn(60);
    const auto points = position(square(), 1000, fixed, density);
    EXPECT_GT(distances(points, fixed).front(), 0.6 * hexagonal_spacing(1.6 * 1060));
    const auto right = std::ranges::count_if(points, [](const Point& p) { return p.x > 0.5; });
    const auto fixed_right = std::ranges::count_if(fixed, [](const Point& p) { return p.x > 0.5; });
    EXPECT_NEAR(static_cast<double>(right + fixed_right), 0.8 * 1060, 15);
}

TEST(Fixed, CanLieAnywhereInAnyOrder) {
    const double most = std::numeric_limits<double>::max();
    std::vector<Point> fixed = drawn(20);
    for (const Point& p : {Point{most, most}, {-most, 0}, {1e-308, 1}, {0, 0}, {1, 0.5}, {-0.01, 0.3}, {7, 7}})
        fixed.push_back(p);
    for (const Domain& domain : {square(), Domain::torus(1, 1).value()}) {
        for (const Quality quality : {Quality::Draft, Quality::Standard}) {
            const auto points = position(domain, 200, fixed, Density::uniform(), quality);
            std::vector<Point> reversed(fixed.rbegin(), fixed.rend());
            EXPECT_EQ(points, position(domain, 200, reversed, Density::uniform(), quality));
        }
    }
}

TEST(Fixed, AreMeshVerticesAfterTheSites) {
    Options options;
    options.sites = 100;
    options.fixed = {{0.5, 0.5}, {0.25, 0.75}};
    options.keep_mesh = true;
    const auto placed = distribute(square(), Density::uniform(), options);
    ASSERT_TRUE(placed);
    ASSERT_TRUE(placed->mesh);
    const auto& vertices = placed->mesh->vertices;
    EXPECT_TRUE(std::ranges::equal(placed->points, std::span(vertices).first(100)));
    for (const Point& p : options.fixed) {
        EXPECT_EQ(std::ranges::count(std::span(vertices).subspan(100, 2), p), 1);
    }
}

}  // namespace
}  // namespace ccdt

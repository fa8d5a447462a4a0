// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/globe_dots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;
using test::Parts;

struct Given {
    Parts parts;
    std::size_t dots;
};

Result<GlobeDots> distribute(const std::vector<Given>& given, double buffer = 0) {
    std::vector<MapFeature> features;
    Parts all;
    for (const auto& [parts, dots] : given) {
        features.push_back({Domain::repair(parts).value().domain, {dots}});
        all.insert(all.end(), parts.begin(), parts.end());
    }
    return distribute_dots_on_globe(features, Domain::repair(all).value().domain, Density::uniform(), {}, buffer);
}

TEST(DistributeDotsOnGlobe, IsEvenOnTheGround) {
    const std::vector<Given> given = {{{{box(10, 50, 10, 20), {}}}, 2000}, {{{box(20, 50, 10, 20), {}}}, 500}};
    const auto placed = distribute(given);
    ASSERT_TRUE(placed) << placed.error().message;
    const ClassDots& dots = placed->classes.front();
    ASSERT_EQ(dots.dots.points.size(), 2500U);
    int north = 0;
    for (std::size_t i = 0; i < dots.feature_of.size(); ++i) {
        const Point p = dots.dots.points[i];
        ASSERT_TRUE(test::contains(given[dots.feature_of[i]].parts, p));
        if (dots.feature_of[i] == 0 && p.y > 60) ++north;
    }
    const auto height = [](double degrees) { return std::sin(degrees * M_PI / 180); };
    EXPECT_NEAR(north / 2000.0, (height(70) - height(60)) / (height(70) - height(50)), 0.01);
    // Area of the ground in square metres, on a sphere with the surface area of the earth.
    const double ground = 6371007.2 * 6371007.2 * (height(70) - height(50)) * 20 * M_PI / 180;
    EXPECT_NEAR(placed->pitch, std::sqrt(ground / 2500), 0.01 * placed->pitch);
}

TEST(DistributeDotsOnGlobe, CrossesTheAntimeridian) {
    const std::vector<Given> given = {{{{box(170, -10, 10, 10), {}}}, 300}, {{{box(-180, -10, 10, 10), {}}}, 300}};
    const auto placed = distribute(given);
    ASSERT_TRUE(placed) << placed.error().message;
    const ClassDots& dots = placed->classes.front();
    double least = 10;
    for (std::size_t i = 0; i < dots.feature_of.size(); ++i) {
        const Point p = dots.dots.points[i];
        ASSERT_TRUE(test::contains(given[dots.feature_of[i]].parts, p));
        for (std::size_t j = 0; j < i; ++j) {
            if (dots.feature_of[j] == dots.feature_of[i]) continue;
            const Point q = dots.dots.points[j];
            least = std::min(least, std::hypot(std::remainder(p.x - q.x, 360), p.y - q.y));
        }
    }
    EXPECT_GT(least, 0.4 * std::sqrt(200.0 / 600));
}

TEST(DistributeDotsOnGlobe, KeepsTheBufferFromTheOuterBorder) {
    // A degree of latitude is 111 km long. Dots may lie on the border between the first two features.
    const std::vector<Given> given = {
        {{{box(0, 0, 2, 2), {}}}, 200}, {{{box(2, 0, 2, 2), {}}}, 200}, {{{box(4, 0.5, 0.5, 0.5), {}}}, 5}};
    const auto placed = distribute(given, 50'000);
    ASSERT_TRUE(placed) << placed.error().message;
    EXPECT_EQ(placed->lost, (std::vector<std::uint32_t>{2}));
    const ClassDots& dots = placed->classes.front();
    ASSERT_EQ(dots.dots.points.size(), 400U);
    double least = 90, nearest = 90;
    for (std::size_t i = 0; i < dots.feature_of.size(); ++i) {
        const Point p = dots.dots.points[i];
        ASSERT_TRUE(test::contains(given[dots.feature_of[i]].parts, p));
        least = std::min({least, p.x, p.y, 2 - p.y, p.x < 4 ? 90 : 4.5 - p.x});
        nearest = std::min(nearest, std::abs(p.x - 2));
    }
    EXPECT_GT(least, 50 / 111.4);
    EXPECT_LT(least, 0.5);
    EXPECT_LT(nearest, 0.1);
    EXPECT_EQ(distribute({given[2]}, 50'000).error().field, "buffer");
}

TEST(DistributeDotsOnGlobe, RefusesTheWholeGlobe) {
    const auto placed = distribute({{{{box(-180, -90, 180, 180), {}}}, 10}, {{{box(0, -90, 180, 180), {}}}, 10}});
    ASSERT_FALSE(placed);
    EXPECT_EQ(placed.error().code, ErrorCode::Unusable);
}

}  // namespace
}  // namespace ccdt

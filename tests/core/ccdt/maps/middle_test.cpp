// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/middle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/ccdt/globe/chart.h"

namespace ccdt {
namespace {

Ring rectangle(double west, double south, double east, double north) {
    return {{west, south}, {east, south}, {east, north}, {west, north}, {west, south}};
}

double distance(Point3 a, Point3 b) {
    return length(a - b);
}

TEST(Middle, IsTheCentroid) {
    const std::vector<PolygonPart> square = {{rectangle(500'000, 5'000'000, 500'002, 5'000'004), {}}};
    EXPECT_LT(distance(*middle_of(square, false), {500'001, 5'000'002, 0}), 1e-9);
    // An L of three unit squares, clockwise.
    const std::vector<PolygonPart> corner = {{{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {2, 1}, {2, 0}}, {}}};
    EXPECT_LT(distance(*middle_of(corner, false), {5.0 / 6, 5.0 / 6, 0}), 1e-12);
}

TEST(Middle, WeighsPartsByArea) {
    const std::vector<PolygonPart> parts = {{rectangle(0, 0, 1, 1), {}}, {rectangle(10, 0, 13, 1), {}}};
    EXPECT_LT(distance(*middle_of(parts, false), {(0.5 + 3 * 11.5) / 4, 0.5, 0}), 1e-12);
}

TEST(Middle, HasNoSeamOnTheGlobe) {
    const auto middle = [](double west, double east) {
        return *middle_of(std::vector<PolygonPart>{{rectangle(west, 10, east, 12), {}}}, true);
    };
    const Direction there = direction_of({180, 11});
    for (const Point3& found : {middle(179, 181), middle(179, -179), middle(-181, -179)})
        EXPECT_LT(distance(found, {there.x, there.y, there.z}), 1e-3);
    const std::vector<PolygonPart> halves = {{rectangle(179, 10, 180, 12), {}}, {rectangle(-180, 10, -179, 12), {}}};
    EXPECT_LT(distance(*middle_of(halves, true), middle(179, 181)), 1e-3);
}

TEST(Middle, IsMissingWithoutArea) {
    EXPECT_FALSE(middle_of({}, false));
    EXPECT_FALSE(middle_of(std::vector<PolygonPart>{{{}, {}}}, false));
    EXPECT_FALSE(middle_of(std::vector<PolygonPart>{{{{1, 1}, {1, 1}, {1, 1}}, {}}}, false));
    EXPECT_FALSE(middle_of(std::vector<PolygonPart>{{{{0, 0}, {3, 1}, {6, 2}, {0, 0}}, {}}}, false));
    EXPECT_FALSE(middle_of(std::vector<PolygonPart>{{rectangle(-1e308, -1e308, 1e308, 1e308), {}}}, false));
}

TEST(Middle, HandlesTheEndsOfRanges) {
    for (const double size : {1e-140, 1e140}) {
        const std::vector<PolygonPart> square = {{rectangle(size, size, 3 * size, 5 * size), {}}};
        EXPECT_LT(distance(1 / size * *middle_of(square, false), {2, 3, 0}), 1e-12) << size;
    }
    const auto beyond = middle_of(std::vector<PolygonPart>{{rectangle(1e300, -1e300, 2e300, 1e300), {}}}, true);
    EXPECT_TRUE(!beyond || std::isfinite(length(*beyond)));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/outlines.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

using Features = std::vector<std::vector<PolygonPart>>;

Ring box(double west, double south, double east, double north) {
    return {{west, south}, {east, south}, {east, north}, {west, north}};
}

/// Returns the lines of features in the plane or, with a projection, of features on the globe.
std::vector<std::vector<Point>> lines_of(const Features& features, const MapProjection* projection = nullptr,
                                         double tolerance = 0) {
    std::vector<std::vector<Point>> lines;
    Outlines outlines(projection, tolerance);
    for (const auto& feature : features) {
        outlines.trace(feature, [&](Point corner, bool begins) {
            if (begins) lines.emplace_back();
            lines.back().push_back(corner);
        });
    }
    return lines;
}

double length_of(const std::vector<std::vector<Point>>& lines) {
    double sum = 0;
    for (const auto& line : lines) {
        for (std::size_t i = 1; i < line.size(); ++i)
            sum += std::hypot(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
    }
    return sum;
}

TEST(Outlines, TracesSharedEdgesOnce) {
    const auto lines = lines_of({{{box(0, 0, 2, 1), {}}}, {{{{2, 0}, {3, 0}, {3, 1}, {2, 1}}, {}}}});
    ASSERT_EQ(lines.size(), 2U);
    EXPECT_EQ(lines[0].size(), 5U);
    EXPECT_EQ(lines[1], (std::vector<Point>{{2, 0}, {3, 0}, {3, 1}, {2, 1}}));
}

TEST(Outlines, TracesHoles) {
    EXPECT_DOUBLE_EQ(length_of(lines_of({{{box(0, 0, 4, 4), {box(1, 1, 2, 2)}}}})), 20);
}

TEST(Outlines, LeavesOutCornersWithinTheTolerance) {
    Ring ring = box(0, 0, 4, 4);
    ring.insert(ring.begin() + 1, {0.01, 0.005});
    const auto lines = lines_of({{{ring, {}}}}, nullptr, 0.1);
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_EQ(lines[0], (std::vector<Point>{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}}));
}

TEST(Outlines, LeavesOutCutsAlongTheAntimeridian) {
    const std::vector<PolygonPart> feature = {{box(177, -19, 180, -16), {}}, {box(-180, -19, -178, -16), {}}};
    const MapProjection map = MapProjection::fitting(feature);
    const double degree = map({179, -19}).x - map({178, -19}).x;
    EXPECT_NEAR(length_of(lines_of({feature}, &map)), 2 * 3 + 10 * degree, 0.1);
    const std::vector<PolygonPart> one_side = {feature.front()};
    EXPECT_NEAR(length_of(lines_of({one_side}, &map)), 2 * 3 + 6 * degree, 0.1);
}

TEST(Outlines, LeavesOutTheWayToThePole) {
    const std::vector<PolygonPart> feature = {{{{-180, -90}, {180, -90}, {180, -70}, {0, -70}, {-180, -70}}, {}}};
    const MapProjection map = MapProjection::fitting(feature);
    const auto lines = lines_of({feature}, &map);
    EXPECT_NEAR(length_of(lines), 2 * std::numbers::pi * map({0, -70}).y, 0.01);
}

TEST(Outlines, ContinuesOnTheOtherSideOfAWorldMap) {
    const std::vector<PolygonPart> world = {{box(-180, -60, 180, 80), {}}};
    const MapProjection map = MapProjection::fitting(world);
    const auto lines = lines_of({{{box(170, 10, 195, 20), {}}}}, &map);
    ASSERT_EQ(lines.size(), 3U);
    const double side = map({179.999999, 10}).x;
    EXPECT_NEAR(lines[0].back().x, side, 1e-5);
    EXPECT_NEAR(lines[1].front().x, -side, 1e-5);
    for (const auto& line : lines) {
        for (const Point& p : line) EXPECT_LE(std::abs(p.x), map({179.999999, 0}).x + 1e-5);
    }
}

}  // namespace
}  // namespace ccdt

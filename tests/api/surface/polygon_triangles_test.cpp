// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/polygon_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace ccdt::api {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::vector<Triangle> divide(const std::vector<Point3>& corners) {
    std::vector<Triangle> triangles(corners.size() - 2);
    divide_polygon(corners, triangles);
    return triangles;
}

/// Returns the area of triangles whose normals agree with an axis, minus that of the others.
double area(const std::vector<Point3>& corners, Point3 axis) {
    double sum = 0;
    for (const auto& [a, b, c] : divide(corners)) {
        const double part = dot(axis, cross(corners[b] - corners[a], corners[c] - corners[a])) / 2;
        EXPECT_GE(part, -1e-12);
        sum += part;
    }
    return sum;
}

TEST(PolygonTriangles, DividesConvexPolygonsIntoAFan) {
    EXPECT_EQ(divide({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(divide({{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 2, 0.5}, {0, 1, 0}}),
              (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(PolygonTriangles, DividesQuadrilateralsAtTheirConcaveCorner) {
    EXPECT_EQ(divide({{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}}), (std::vector<Triangle>{{3, 0, 1}, {3, 1, 2}}));
    EXPECT_EQ(divide({{0, 0, 0}, {1, 1, 0}, {0, 2, 0}, {2, 1, 0}}), (std::vector<Triangle>{{1, 2, 3}, {1, 3, 0}}));
}

TEST(PolygonTriangles, DividesConcavePolygonsInAnyPlane) {
    // A comb with seven teeth, forwards and backwards, in planes along each axis, near and far from the origin.
    for (const double origin : {0.0, 5e6}) {
        for (int axis = 0; axis < 6; ++axis) {
            const auto position = [&](double u, double v) {
                if (axis >= 3) std::swap(u, v);
                Point3 p{u, v, 0};
                if (axis % 3 == 1) p = {0, u, v};
                if (axis % 3 == 2) p = {v, 0, u};
                return p + Point3(origin, origin, origin);
            };
            std::vector<Point3> comb{position(0, 0), position(13, 0)};
            for (int i = 13; i >= 0; --i) {
                comb.push_back(position(i, i % 2 == 0 ? 10 : 1));
            }
            const Point3 normal = axis % 3 == 0 ? Point3(0, 0, 1) : axis % 3 == 1 ? Point3(1, 0, 0) : Point3(0, 1, 0);
            EXPECT_NEAR(area(comb, axis < 3 ? normal : -1.0 * normal), 13 * 5.5, 1e-6) << axis;
        }
    }
}

TEST(PolygonTriangles, DividesPolygonsWithBridgesToHoles) {
    // A square with a square hole, whose bridge is passed twice.
    const std::vector<Point3> ring{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0},
                                   {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
    EXPECT_NEAR(area(ring, {0, 0, 1}), 8, 1e-12);
}

TEST(PolygonTriangles, DividesLargeStars) {
    std::vector<Point3> star;
    constexpr int kSize = 4000;
    for (int i = 0; i < kSize; ++i) {
        const double angle = 2 * std::numbers::pi * i / kSize, radius = i % 2 == 0 ? 1 : 0.5;
        star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    EXPECT_NEAR(area(star, {0, 0, 1}), kSize / 2 * std::sin(2 * std::numbers::pi / kSize) / 2, 1e-9);
}

TEST(PolygonTriangles, UsesEachCornerOfAnInvalidPolygon) {
    // A bow tie, a line, a point, and coordinates that are not finite.
    const double infinity = std::numeric_limits<double>::infinity();
    const std::vector<std::vector<Point3>> polygons{
        {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 2, 0}},
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1.5, 0, 0}, {0.5, 0, 0}},
        std::vector<Point3>(6),
        {{0, 0, 0}, {infinity, 1, 0}, {1, 0, 0}, {0, std::nan(""), 0}, {0.5, 2, 0}},
    };
    for (const auto& polygon : polygons) {
        std::vector<std::uint32_t> used;
        for (const auto& triangle : divide(polygon)) used.insert(used.end(), triangle.begin(), triangle.end());
        std::ranges::sort(used);
        used.erase(std::unique(used.begin(), used.end()), used.end());
        EXPECT_EQ(used.size(), polygon.size());
    }
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/delaunay3.h"

#include <stop_token>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

double six_volumes(std::span<const Point3> points, const Tetrahedron& corners) {
    const Point3 a = points[corners[0]];
    return dot(cross(points[corners[1]] - a, points[corners[2]] - a), points[corners[3]] - a);
}

std::vector<Point3> random_points(std::size_t count) {
    Random random(1, 0);
    std::vector<Point3> points(count);
    for (Point3& p : points) p = {random.uniform(), random.uniform(), random.uniform()};
    return points;
}

TEST(DelaunayTetrahedra, FillTheConvexHull) {
    std::vector<Point3> points = random_points(200);
    for (const double x : {0, 1}) {
        for (const double y : {0, 1}) {
            for (const double z : {0, 1}) points.push_back({x, y, z});
        }
    }
    double sum = 0;
    for (const Tetrahedron& corners : delaunay_tetrahedra(points)) {
        const double volume = six_volumes(points, corners) / 6;
        EXPECT_GT(volume, 0);
        sum += volume;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(DelaunayTetrahedra, HaveEmptySpheres) {
    const std::vector<Point3> points = random_points(60);
    const auto tetrahedra = delaunay_tetrahedra(points);
    ASSERT_FALSE(tetrahedra.empty());
    for (const auto& [a, b, c, d] : tetrahedra) {
        const Point3 u = points[b] - points[a], v = points[c] - points[a], w = points[d] - points[a];
        const Point3 top = dot(u, u) * cross(v, w) + dot(v, v) * cross(w, u) + dot(w, w) * cross(u, v);
        const Point3 to_centre = (1 / (2 * dot(u, cross(v, w)))) * top;
        for (const Point3 p : points) EXPECT_GE(length(p - points[a] - to_centre), length(to_centre) * (1 - 1e-9));
    }
}

TEST(DelaunayTetrahedra, AreNoneForPointsInAPlane) {
    EXPECT_TRUE(delaunay_tetrahedra({}).empty());
    const std::vector<Point3> flat{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.3, 0.4, 1}};
    EXPECT_TRUE(delaunay_tetrahedra(flat).empty());
}

TEST(DelaunayTetrahedra, ShareVerticesOfCoincidentPoints) {
    const std::vector<Point3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
    EXPECT_EQ(delaunay_tetrahedra(points).size(), 1u);
}

TEST(DelaunayTetrahedra, AreNoneAfterAStop) {
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(delaunay_tetrahedra(random_points(20), source.get_token()).empty());
}

}  // namespace
}  // namespace ccdt

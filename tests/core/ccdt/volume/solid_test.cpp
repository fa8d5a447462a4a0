// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/solid.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/solids.h"

namespace ccdt {
namespace {

using test::solid_of;

TEST(Solid, ContainsTheInsideOfACube) {
    const Solid cube = solid_of(test::cube_surface({10, 20, 30}, 2));
    EXPECT_NEAR(cube.volume(), 8, 1e-9);
    EXPECT_NEAR(length(cube.bounds().min - Point3{10, 20, 30}), 0, 1e-9);
    EXPECT_NEAR(length(cube.bounds().max - Point3{12, 22, 32}), 0, 1e-9);
    // Lines through these points along x meet edges and vertices of the cube.
    for (const double v : {0.5, 1.0, 1.5}) {
        EXPECT_TRUE(cube.contains({11, 20 + v, 30 + v}));
        EXPECT_FALSE(cube.contains({9, 20 + v, 30 + v}));
        EXPECT_FALSE(cube.contains({11, 19, 30 + v}));
        EXPECT_FALSE(cube.contains({9.999, 20, 30 + v}));
        EXPECT_FALSE(cube.contains({12.001, 22, 32}));
    }
    EXPECT_FALSE(cube.contains({std::numeric_limits<double>::quiet_NaN(), 21, 31}));
    EXPECT_FALSE(cube.contains({1e308, -1e308, 31}));
}

TEST(Solid, LeavesOutTheHoleOfARing) {
    const Solid ring = solid_of(test::torus_surface(1, 0.25, 96, 48));
    EXPECT_NEAR(ring.volume(), 2 * std::pow(std::numbers::pi * 0.25, 2), 0.006);
    EXPECT_FALSE(ring.contains({0, 0, 0}));
    EXPECT_TRUE(ring.contains({0, 1, 0}));
    EXPECT_TRUE(ring.contains({-0.8, 0, 0}));
}

TEST(Solid, SubtractsCavitiesAndCountsOverlapsOnce) {
    const TriangleSoup outer = test::sphere_surface(3), inner = test::moved(outer, 0.5, {0.1, 0, 0});
    const double volume = solid_of(outer).volume();
    const Solid hollow = solid_of(test::joined(outer, test::turned_over(inner)));
    EXPECT_NEAR(hollow.volume(), 0.875 * volume, 1e-9);
    EXPECT_FALSE(hollow.contains({0, 0, 0}));
    EXPECT_TRUE(hollow.contains({-0.7, 0, 0}));

    const Solid nested = solid_of(test::joined(outer, inner));
    EXPECT_NEAR(nested.volume(), volume, 1e-9);
    EXPECT_TRUE(nested.contains({0, 0, 0}));

    const Solid pair = solid_of(test::joined(test::cube_surface({0, 0, 0}), test::cube_surface({0.5, 0.5, 0.5})));
    EXPECT_NEAR(pair.volume(), 1.875, 0.02);
    EXPECT_TRUE(pair.contains({0.75, 0.75, 0.75}));
    EXPECT_FALSE(pair.contains({1.25, 0.25, 0.25}));
}

TEST(Solid, ContainsTheInsideOfAPrismOfNeedles) {
    constexpr int kSides = 1000;
    const Solid prism = solid_of(test::needle_prism(kSides));
    const double radius = 0.5 * std::cos(std::numbers::pi / kSides), along = 1 / std::sqrt(3.0);
    EXPECT_NEAR(prism.volume(), 3 * std::numbers::pi * 0.25, 1e-4);
    Random random(5, 1);
    const auto coordinate = [&] { return 4 * random.uniform() - 1; };
    for (int i = 0; i < 2000; ++i) {
        const Point3 p{coordinate(), coordinate(), coordinate()};
        const double at = along * (p.x + p.y + p.z), off = std::sqrt(dot(p, p) - at * at);
        if (off > radius && off < 0.5) continue;
        EXPECT_EQ(prism.contains(p), at > 0 && at < 3 && off < radius);
    }
}

TEST(Solid, DoesNotDependOnTheOrientationOfTheSoup) {
    const Solid ball = solid_of(test::turned_over(test::sphere_surface(2)));
    EXPECT_TRUE(ball.contains({0.5, 0.5, 0.5}));
    EXPECT_NEAR(ball.volume(), solid_of(test::sphere_surface(2)).volume(), 1e-12);
}

TEST(Solid, OrientsShellsAcrossCreases) {
    TriangleSoup cube = test::cube_surface();
    for (std::size_t i = 0; i < 2; ++i) std::swap(cube.triangles[i][1], cube.triangles[i][2]);  // one side
    auto made = Surface::create(cube, 0.5);
    ASSERT_TRUE(made);
    const auto solid = Solid::create(std::move(made->surface));
    ASSERT_TRUE(solid);
    EXPECT_NEAR(solid->volume(), 1, 1e-9);
    for (const double v : {0.1, 0.5, 0.9}) EXPECT_TRUE(solid->contains({v, v, v})) << v;
}

TEST(Solid, MeasuresTheShareOfEachCell) {
    const TriangleSoup tetrahedron{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                   .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    const Solid solid = solid_of(tetrahedron);
    EXPECT_NEAR(solid.volume(), 1.0 / 6, 1e-9);
    const Solid::Coverage coverage = solid.coverage(8);
    ASSERT_EQ(coverage.cells, (std::array<std::size_t, 3>{2, 2, 2}));
    // A cell at the origin, without a corner of 1/48; three corners of 1/48; and nothing beyond the plane.
    const std::array<double, 8> expected{5. / 6, 1. / 6, 1. / 6, 0, 1. / 6, 0, 0, 0};
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(coverage.shares[i], expected[i], 1e-9) << i;
}

TEST(Solid, RejectsOpenAndFlatSurfaces) {
    TriangleSoup open = test::cube_surface();
    open.triangles.pop_back();
    const auto result = Solid::create(test::surface_of(open));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_NE(result.error().message.find("only one triangle has the edge from (1, "), std::string::npos)
        << result.error().message;

    TriangleSoup flat = test::cube_surface();
    for (Point3& p : flat.vertices) p.z *= 1e-17;
    for (const TriangleSoup& soup : {flat, test::cube_surface({0, 0, 0}, 1e-145), test::cube_surface({}, 1e308)}) {
        const auto made = Surface::create(soup, std::nullopt);
        EXPECT_FALSE(made && Solid::create(test::surface_of(soup)));
    }
}

TEST(Solid, StopsWhileItIsMade) {
    std::stop_source source;
    source.request_stop();
    auto surface = std::move(Surface::create(test::cube_surface(), std::nullopt, {}).value().surface);
    const auto solid = Solid::create(std::move(surface), source.get_token());
    ASSERT_FALSE(solid);
    EXPECT_EQ(solid.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt

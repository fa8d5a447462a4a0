// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/move_guard.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

constexpr double kHeight = 1e-9;

/// Returns a square with a site at its centre.
Triangulation one_site() {
    const test::Parts square{{test::box(0, 0, 1, 1), {}}};
    Triangulation mesh = mesh_of_border(1, triangulate(bare_border(test::domain_of(square))).value());
    EXPECT_TRUE(insert_site(mesh, 0, {0.5, 0.5}));
    trim(mesh);
    return mesh;
}

/// Moves the site, and returns its position after the check.
Point checked(Point to, int halvings, bool large = true) {
    Triangulation mesh = one_site();
    const std::vector<Point> before{mesh.point(0)};
    mesh.points()[0] = to;
    MoveGuard().check(mesh, before, kHeight, halvings, [=](std::uint32_t, double) { return large; });
    EXPECT_EQ(test::count_inverted(mesh), 0u);
    return mesh.point(0);
}

TEST(MoveGuard, KeepsMovesThatLeaveATenthOfEachArea) {
    EXPECT_EQ(checked({0.5, 0.94}, 0), (Point{0.5, 0.94}));
    EXPECT_EQ(checked({0.5, 0.96}, 0), (Point{0.5, 0.5}));
}

TEST(MoveGuard, HalvesMovesBeforeItRevertsThem) {
    EXPECT_EQ(checked({0.5, 1.5}, 1), (Point{0.5, 0.5}));
    EXPECT_EQ(checked({0.5, 1.5}, 3), (Point{0.5, 0.75}));
    EXPECT_EQ(checked({0.5, 1.25}, 1), (Point{0.5, 0.875}));
}

TEST(MoveGuard, ComparesEachMoveWithThePositionsBeforeIt) {
    Triangulation mesh = one_site();
    MoveGuard guard;
    const auto is_large = [](std::uint32_t, double area) { return area > 0.01; };
    for (const double y : {0.6, 0.9, 0.985, 0.997}) {
        const std::vector<Point> before{mesh.point(0)};
        mesh.points()[0] = {0.5, y};
        guard.check(mesh, before, kHeight, 0, is_large);
    }
    EXPECT_EQ(mesh.point(0).y, 0.997);
}

TEST(NeedleArea, IsTheLargerOfTwoBounds) {
    EXPECT_DOUBLE_EQ(needle_area({0, 0}, {3, 4}, {1, 0}, 0), 25 * kMinShape);
    EXPECT_DOUBLE_EQ(needle_area({1, 0}, {0, 0}, {3, 4}, 0.5), 2.5);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/resettlement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "core/ccdt/relax/relaxation.h"
#include "core/mesh/flips.h"
#include "core/mesh/relocation.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::Parts;
using test::StartMesh;

const Parts kStrip{{test::box(0, 0, 1, 0.1), {}}};

std::ptrdiff_t count_left_of(const Triangulation& mesh, double x) {
    return std::count_if(mesh.points().begin(), mesh.points().begin() + static_cast<std::ptrdiff_t>(mesh.site_count()),
                         [x](Point p) { return p.x < x; });
}

/// Moves the sites nearest to `from`, one by one, into the triangle nearest to `to`.
void crowd(Triangulation& mesh, Point from, Point to, int count) {
    const auto distance = [](Point a, Point b) { return std::sqrt(dot(a - b, a - b)); };
    for (int i = 0; i < count; ++i) {
        std::uint32_t site = 0, triangle = 0;
        for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
            if (distance(mesh.point(v), from) < distance(mesh.point(site), from)) site = v;
        }
        const auto middle = [&](std::uint32_t t) {
            const auto [a, b, c] = mesh.positions(t);
            return 1.0 / 3 * (a + b + c);
        };
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
            if (distance(middle(t), to) < distance(middle(triangle), to)) triangle = t;
        }
        ASSERT_TRUE(relocate_site(mesh, site, triangle, middle(triangle)));
    }
}

TEST(Resettlement, MovesSitesToWhereTheyAreMissing) {
    constexpr std::size_t kSites = 60;
    StartMesh start(domain_of(kStrip), Density::uniform(), {.sites = kSites, .seed = 2});
    crowd(start.mesh, {0, 0.05}, {0.95, 0.05}, 5);
    ASSERT_LT(count_left_of(start.mesh, 0.2), 8);
    for (int round = 0; round < 5; ++round) {
        start.measure();
        Resettlement(start.mesh, start.goals).even_out();
    }
    EXPECT_NEAR(static_cast<double>(count_left_of(start.mesh, 0.2)), 0.2 * kSites, 1.5);
    EXPECT_NEAR(static_cast<double>(count_left_of(start.mesh, 0.8)), 0.8 * kSites, 1.5);
    EXPECT_EQ(test::count_inverted(start.mesh), 0u);
    EXPECT_EQ(test::count_not_delaunay(start.mesh), 0u);
}

TEST(Resettlement, KeepsEvenSites) {
    StartMesh start(domain_of(kStrip), Density::uniform(), {.sites = 60, .seed = 2});
    for (int round = 0; round < 5; ++round) {
        start.measure();
        Relaxation relaxation(start.mesh, start.border.corner, true, {});
        relaxation.prepare(start.goals);
        for (int pass = 0; pass < 5; ++pass) relaxation.pass();
        restore_delaunay(start.mesh);
    }
    const auto before = start.mesh.points();
    start.measure();
    EXPECT_EQ(Resettlement(start.mesh, start.goals).even_out(), 0u);
    EXPECT_EQ(start.mesh.points(), before);
}

TEST(Resettlement, StaysWithinAPart) {
    StartMesh start(domain_of({{test::box(0, 0, 0.45, 0.1), {}}, {test::box(0.55, 0, 0.45, 0.1), {}}}),
                    Density::uniform(), {.sites = 60, .seed = 2});
    crowd(start.mesh, {0, 0.05}, {0.95, 0.05}, 10);
    const auto before = count_left_of(start.mesh, 0.5);
    for (int round = 0; round < 3; ++round) {
        start.measure();
        Resettlement(start.mesh, start.goals).even_out();
        EXPECT_EQ(count_left_of(start.mesh, 0.5), before);
    }
}

TEST(Resettlement, MovesASiteToTheSparsestPlace) {
    StartMesh start(domain_of(kStrip), Density::uniform(), {.sites = 60, .seed = 2});
    crowd(start.mesh, {0, 0.05}, {0.95, 0.05}, 4);
    start.measure();
    std::uint32_t last = 0;
    for (std::uint32_t v = 0; v < 60; ++v) {
        if (start.mesh.point(v).x > start.mesh.point(last).x) last = v;
    }
    Resettlement resettlement(start.mesh, start.goals);
    EXPECT_TRUE(resettlement.move_away(last));
    EXPECT_LT(start.mesh.point(last).x, 0.2);
    EXPECT_FALSE(resettlement.move_away(last)) << "a relocated site cannot move again";
}

/// Each of two islands has one site, next to the strait between them.
TEST(Resettlement, SeparatesTheOnlySitesOfTwoIslands) {
    StartMesh start(domain_of({{test::box(0, 0, 0.49, 0.2), {}}, {test::box(0.51, 0, 0.49, 0.2), {}}}),
                    Density::uniform(), {.sites = 2, .seed = 4});
    for (std::uint32_t v = 0; v < 2; ++v) {
        start.mesh.points()[v] = {start.mesh.point(v).x < 0.5 ? 0.47 : 0.53, 0.1};
    }
    restore_delaunay(start.mesh);
    start.measure();
    EXPECT_TRUE(Resettlement(start.mesh, start.goals).separate({0, 1}));
    EXPECT_GT(std::abs(start.mesh.point(1).x - start.mesh.point(0).x), 0.25);
    EXPECT_NE(start.mesh.point(0).x < 0.5, start.mesh.point(1).x < 0.5) << "no site leaves its island";
    EXPECT_EQ(test::count_inverted(start.mesh), 0u);
    EXPECT_FALSE(Resettlement(start.mesh, start.goals).separate({0, 1})) << "no better place for either site";
}

TEST(Resettlement, MakesNoFlatTriangles) {
    StartMesh start(domain_of(kStrip), Density::uniform(), {.sites = 60, .seed = 2});
    crowd(start.mesh, {0, 0.05}, {0.95, 0.05}, 5);
    start.measure();
    EXPECT_EQ(Resettlement(start.mesh, start.goals, 1).even_out(), 0u);
    EXPECT_GT(Resettlement(start.mesh, start.goals, 1e-9).even_out(), 0u);
}

}  // namespace
}  // namespace ccdt

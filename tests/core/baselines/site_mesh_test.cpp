// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/site_mesh.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::Parts;

SiteMesh start(const Domain& domain, const Density& density, std::size_t sites) {
    return SiteMesh::create(domain, density, {.sites = sites, .seed = 5}, {}).value();
}

std::vector<Point> moved_at_random(const SiteMesh& sites, double size, std::uint64_t seed) {
    Random random(seed, 0);
    std::vector<Point> wanted;
    for (const Point& p : sites.sites()) {
        const double x = random.uniform() - 0.5;
        wanted.push_back(p + size * Point{x, random.uniform() - 0.5});
    }
    return wanted;
}

/// Reflects a number into [0, 1].
double folded(double x) {
    return std::abs(x - 2 * std::round(x / 2));
}

TEST(SiteMesh, MovesSitesToTheWantedPositions) {
    const Domain square = Domain::rectangle(1, 1).value();
    const Density uniform = Density::uniform();
    // Small moves keep the triangles, large ones invert many of them.
    for (const double size : {1e-4, 1e-2, 2.0}) {
        SiteMesh sites = start(square, uniform, 500);
        for (std::uint64_t round = 0; round < 5; ++round) {
            auto wanted = moved_at_random(sites, size, round);
            for (Point& p : wanted) p = {folded(p.x), folded(p.y)};
            ASSERT_TRUE(sites.move(wanted));
            EXPECT_TRUE(std::ranges::equal(sites.sites(), wanted)) << size;
            EXPECT_EQ(test::count_inverted(sites.mesh()), 0u);
            EXPECT_EQ(test::count_not_delaunay(sites.mesh()), 0u);
            EXPECT_EQ(test::count_bad_links(sites.mesh()), 0u);
        }
    }
}

TEST(SiteMesh, KeepsSitesInTheDomain) {
    for (const Parts& parts : {Parts{{test::u_shape(), {}}}, Parts{{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}}}) {
        const Domain domain = domain_of(parts);
        const Density uniform = Density::uniform();
        SiteMesh sites = start(domain, uniform, 200);
        for (std::uint64_t round = 0; round < 10; ++round) {
            ASSERT_TRUE(sites.move(moved_at_random(sites, 1.0, round)));
            std::vector<Point> positions;
            for (const Point& p : sites.sites()) positions.push_back(domain.to_user(p));
            EXPECT_EQ(test::count_outside(parts, positions), 0u);
            EXPECT_EQ(test::count_distinct(positions), 200u);
            EXPECT_EQ(test::count_bad_links(sites.mesh()), 0u);
        }
    }
}

TEST(SiteMesh, KeepsTheMarginOfCoordinateResolution) {
    const Domain far = domain_of(test::moved({{test::box(0, 0, 1, 1), {}}}, {5e8, 5e8}));
    const Density uniform = Density::uniform();
    SiteMesh sites = start(far, uniform, 1);
    for (const double share : {0.9, 0.5, 0.0}) {
        ASSERT_TRUE(sites.move(std::vector<Point>{{0.5, share * far.resolution()}}));
        EXPECT_GE(sites.sites()[0].y, far.resolution());
    }
}

TEST(SiteMesh, MovesTheShorterWayOnATorus) {
    const Domain torus = Domain::torus(1, 1).value();
    const Density uniform = Density::uniform();
    SiteMesh sites = start(torus, uniform, 100);
    const std::vector<Point> before(sites.sites().begin(), sites.sites().end());
    std::vector<Point> wanted;
    for (const Point& p : before) wanted.push_back(snapped({p.x < 0.5 ? p.x + 1.01 : p.x + 0.01, p.y - 1}));
    ASSERT_TRUE(sites.move(wanted));
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_NEAR(sites.sites()[i].x, before[i].x + 0.01, 1e-14);
        EXPECT_NEAR(sites.sites()[i].y, before[i].y, 1e-14);
    }
}

}  // namespace
}  // namespace ccdt

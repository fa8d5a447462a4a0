// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/plane/start.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"
#include "core/mesh/relocation.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::count_bad_links;
using test::count_inverted;
using test::count_not_delaunay;
using test::domain_of;
using test::Parts;
using test::StartMesh;

const Parts kSquare{{test::box(0, 0, 1, 1), {}}};

Triangulation empty_mesh(const Parts& parts, std::size_t sites) {
    return mesh_of_border(sites, triangulate(bare_border(domain_of(parts))).value());
}

void expect_valid(const Triangulation& mesh, std::size_t parts, std::size_t holes) {
    EXPECT_EQ(count_inverted(mesh), 0u);
    EXPECT_EQ(count_not_delaunay(mesh), 0u);
    EXPECT_EQ(count_bad_links(mesh), 0u);
    const std::size_t border = mesh.vertex_count() - mesh.site_count();
    EXPECT_EQ(mesh.triangle_count(), 2 * mesh.site_count() + border + 2 * holes - 2 * parts);
}

TEST(Triangulation, SplitsASquareAtItsCentre) {
    Triangulation mesh = empty_mesh(kSquare, 1);
    ASSERT_TRUE(insert_site(mesh, 0, {0.5, 0.5}));
    trim(mesh);
    ASSERT_EQ(mesh.triangle_count(), 4u);
    EXPECT_EQ(mesh.vertex_count(), 5u);
    for (std::uint32_t t = 0; t < 4; ++t) EXPECT_DOUBLE_EQ(mesh.doubled_area(t), 0.5);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, RefusesPositionsNotStrictlyInside) {
    const Parts ring{{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}};
    Triangulation mesh = empty_mesh(ring, 1);
    EXPECT_FALSE(insert_site(mesh, 0, {0.5, 0.5})) << "in the hole";
    EXPECT_FALSE(insert_site(mesh, 0, {0.5, 0})) << "on the border";
    EXPECT_FALSE(insert_site(mesh, 0, {0.25, 0.5})) << "on the hole's border";
    EXPECT_FALSE(insert_site(mesh, 0, {0, 0})) << "on a corner";
    EXPECT_TRUE(insert_site(mesh, 0, {0.125, 0.5}));
    trim(mesh);
    expect_valid(mesh, 1, 1);
}

TEST(Triangulation, RefusesAnOccupiedPosition) {
    Triangulation mesh = empty_mesh(kSquare, 2);
    EXPECT_TRUE(insert_site(mesh, 0, {0.25, 0.5}));
    EXPECT_FALSE(insert_site(mesh, 1, {0.25, 0.5}));
    EXPECT_TRUE(insert_site(mesh, 1, {0.25, std::nextafter(0.5, 1.0)}));
    trim(mesh);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, AcceptsSitesOnEdgesAndCircles) {
    // Each site of the lattice lies on edges of earlier sites, and groups of four are cocircular.
    constexpr int kSide = 31;
    Triangulation mesh = empty_mesh(kSquare, kSide * kSide);
    std::uint32_t site = 0;
    for (int j = 1; j <= kSide; ++j) {
        for (int i = 1; i <= kSide; ++i) ASSERT_TRUE(insert_site(mesh, site++, {i / 32.0, j / 32.0}));
    }
    trim(mesh);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, AcceptsSitesCrowdedAtOnePosition) {
    Random random(4, 0);
    Triangulation mesh = empty_mesh(kSquare, 500);
    for (std::uint32_t i = 0; i < 500; ++i) {
        const double distance = std::pow(10.0, -12 * random.uniform()), angle = 6.28 * random.uniform();
        ASSERT_TRUE(
            insert_site(mesh, i, {0.5 + 0.4 * distance * std::cos(angle), 0.5 + 0.4 * distance * std::sin(angle)}));
    }
    trim(mesh);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, IsValidInAllShapes) {
    struct Case {
        Parts parts;
        std::size_t holes;
    };
    const std::vector<Case> cases{{kSquare, 0},
                                  {{{test::u_shape(), {}}}, 0},
                                  {{test::sieve(5)}, 25},
                                  {{{test::box(0, 0, 8, 8), {test::box(2, 2, 4, 4)}}, {test::box(3, 3, 1, 1), {}}}, 1},
                                  {test::read_geojson("South-Africa-50m.geojson"), 1},
                                  {test::read_geojson("Switzerland-10m.geojson"), 0},
                                  {test::read_geojson("Italy-110m.geojson"), 0}};
    for (const Case& c : cases) {
        for (const std::size_t sites : {1, 10, 1000}) {
            const StartMesh start(domain_of(c.parts), Density::uniform(), Options{.sites = sites, .seed = sites});
            SCOPED_TRACE(sites);
            expect_valid(start.mesh, c.parts.size(), c.holes);
        }
    }
}

TEST(Triangulation, InsertsAllSitesOnAnyNumberOfThreads) {
    constexpr std::size_t kSites = 30'000;
    const Options options{.sites = kSites, .seed = 3};
    const Parts ring{{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}};
    const Domain domain = domain_of(ring);
    const Density density = Density::uniform();
    const StartSites start(domain, density, options);
    std::vector<std::uint32_t> coarse, fine;
    for (std::uint32_t site = 0; site < kSites; ++site) (site % 8 == 0 ? coarse : fine).push_back(site);
    const auto corners_by = [&](Executor& executor) {
        Triangulation mesh = empty_mesh(ring, kSites);
        mesh.set_executor(executor);
        for (const auto& sites : {coarse, fine}) {
            const auto draw = [&](std::uint32_t site, int attempt) { return start.draw(site, attempt); };
            for (const std::uint32_t site : insert_sites(mesh, sites, draw, 16, 0)) {
                for (int attempt = 16; !insert_site(mesh, site, start.draw(site, attempt)); ++attempt) continue;
            }
        }
        trim(mesh);
        expect_valid(mesh, 1, 1);
        std::vector<std::array<std::uint32_t, 3>> corners;
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) corners.push_back(mesh.corners(t));
        return corners;
    };
    const auto expected = corners_by(inline_executor());
    for (const std::size_t size : {2, 5}) {
        ThreadExecutor executor(size);
        EXPECT_EQ(corners_by(executor), expected);
    }
}

TEST(Triangulation, ReturnsSitesWithoutAPosition) {
    // Half of the sites are drawn outside: these are returned, and all others are inserted.
    constexpr std::size_t kSites = 10'000;
    Triangulation mesh = empty_mesh(kSquare, kSites);
    std::vector<std::uint32_t> sites(kSites);
    std::iota(sites.begin(), sites.end(), 0u);
    const auto draw = [](std::uint32_t site, int) {
        Random random(1, site);
        const double x = random.uniform(), y = random.uniform();
        return Point{site % 2 == 0 ? x : x + 1.5, y};
    };
    const auto remaining = insert_sites(mesh, sites, draw, 2, 0);
    ASSERT_EQ(remaining.size(), kSites / 2);
    for (const std::uint32_t site : remaining) {
        ASSERT_EQ(site % 2, 1u);
        const Point p = draw(site, 0);
        ASSERT_TRUE(insert_site(mesh, site, {p.x - 1.5, p.y}));
    }
    trim(mesh);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, IsDelaunayAgainAfterMoves) {
    StartMesh start(domain_of(kSquare), Density::uniform(), Options{.sites = 2000, .seed = 5});
    Triangulation& mesh = start.mesh;
    Random random(6, 0);
    for (int round = 0; round < 5; ++round) {
        test::stir(mesh, random);
        ASSERT_EQ(count_inverted(mesh), 0u);
        EXPECT_GT(count_not_delaunay(mesh), 0u);
        EXPECT_GT(restore_delaunay(mesh), 0u);
        expect_valid(mesh, 1, 0);
    }
    EXPECT_EQ(restore_delaunay(mesh), 0u);
}

TEST(Triangulation, StaysValidWhenFlippingIsStopped) {
    Triangulation mesh = empty_mesh(kSquare, 2);
    ASSERT_TRUE(insert_site(mesh, 0, {0.5, 0.4}));
    ASSERT_TRUE(insert_site(mesh, 1, {0.5, 0.6}));
    trim(mesh);
    mesh.points()[0] = {0.1, 0.45};
    mesh.points()[1] = {0.9, 0.55};
    ASSERT_GT(count_not_delaunay(mesh), 0u);
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(restore_delaunay(mesh, source.get_token()), 0u);
    EXPECT_EQ(count_bad_links(mesh), 0u);
    EXPECT_GT(restore_delaunay(mesh), 0u);
    expect_valid(mesh, 1, 0);
}

TEST(Triangulation, RelocatesSites) {
    constexpr std::uint32_t kSites = 60;
    const Parts ring{{test::box(0, 0, 4, 4), {test::box(1, 1, 2, 2)}}};
    StartMesh start(domain_of(ring), Density::uniform(), {.sites = kSites, .seed = 5});
    Triangulation& mesh = start.mesh;
    Random random(3, 1);
    int relocated = 0;
    for (std::uint32_t round = 0; round < 300; ++round) {
        const std::uint32_t site = round % kSites;
        const auto triangle = static_cast<std::uint32_t>(random.uniform() * static_cast<double>(mesh.triangle_count()));
        if (std::ranges::count(mesh.corners(triangle), site) > 0) continue;
        const auto [a, b, c] = mesh.positions(triangle);
        const Point to = 1.0 / 3 * (a + b + c);
        ASSERT_TRUE(relocate_site(mesh, site, triangle, to));
        ASSERT_EQ(mesh.point(site), to);
        ASSERT_EQ(mesh.origin(mesh.edge_of(site)), site);
        ++relocated;
        expect_valid(mesh, 1, 1);
    }
    EXPECT_GT(relocated, 200);
    EXPECT_EQ(restore_delaunay(mesh), 0u);
}

TEST(Triangulation, RelocatesSitesWithinTheirOwnTriangles) {
    Triangulation mesh = empty_mesh({{test::circle({0.5, 0.5}, 0.5, 9), {}}}, 1);
    ASSERT_TRUE(insert_site(mesh, 0, {0.45, 0.55}));
    trim(mesh);
    for (std::uint32_t triangle = 0; triangle < mesh.triangle_count(); ++triangle) {
        const auto [a, b, c] = mesh.positions(triangle);
        const Point to = 1.0 / 3 * (a + b + c);
        ASSERT_TRUE(relocate_site(mesh, 0, triangle, to));
        ASSERT_EQ(mesh.point(0), to);
        expect_valid(mesh, 1, 0);
    }
    EXPECT_EQ(restore_delaunay(mesh), 0u);
}

/// On both diagonals of a square, flipping an edge away from the site would create a flat triangle.
TEST(Triangulation, KeepsSitesWhoseEdgesCannotBeFlipped) {
    Triangulation mesh = empty_mesh({{test::box(0, 0, 0.5, 0.5), {}}, {test::box(0.75, 0, 0.25, 0.25), {}}}, 1);
    ASSERT_TRUE(insert_site(mesh, 0, {0.25, 0.25}));
    trim(mesh);
    std::uint32_t triangle = 0;
    while (mesh.part_of(mesh.corners(triangle)[0]) == mesh.part_of(0)) ++triangle;
    const auto [a, b, c] = mesh.positions(triangle);
    EXPECT_FALSE(relocate_site(mesh, 0, triangle, 1.0 / 3 * (a + b + c)));
    EXPECT_EQ(mesh.point(0), (Point{0.25, 0.25}));
    expect_valid(mesh, 2, 0);
}

TEST(Triangulation, ReportsVerticesChangedByFlips) {
    Triangulation mesh = empty_mesh(kSquare, 4);
    ASSERT_TRUE(insert_site(mesh, 0, {0.5, 0.3}));
    ASSERT_TRUE(insert_site(mesh, 1, {0.5, 0.7}));
    ASSERT_TRUE(insert_site(mesh, 2, {0.25, 0.5}));
    ASSERT_TRUE(insert_site(mesh, 3, {0.75, 0.5}));
    trim(mesh);
    EXPECT_EQ(restore_delaunay(mesh), 0u);
    for (std::uint32_t v = 0; v < 4; ++v) EXPECT_FALSE(mesh.has_changed(v));
    // The short diagonal of the four was 0-1 before the move and is 2-3 after it.
    mesh.points()[2] = {0.45, 0.5};
    mesh.points()[3] = {0.55, 0.5};
    EXPECT_GE(restore_delaunay(mesh), 1u);
    for (std::uint32_t v = 0; v < 4; ++v) EXPECT_TRUE(mesh.has_changed(v));
    expect_valid(mesh, 1, 0);
}

}  // namespace
}  // namespace ccdt

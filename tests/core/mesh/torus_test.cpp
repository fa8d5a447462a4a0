// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/predicates.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/inside.h"
#include "core/mesh/triangulation.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::count_bad_links;
using test::count_inverted;
using test::count_not_delaunay;

Point period_of(double width, double height) {
    return Domain::torus(width, height).value().unit_bounds().max;
}

/// Returns the triangulation of a torus with given sites.
Triangulation mesh_of(Point period, const std::vector<Point>& sites) {
    Triangulation mesh(sites.size(), period);
    for (std::uint32_t i = 0; i < sites.size(); ++i) EXPECT_TRUE(insert_site(mesh, i, sites[i])) << i;
    trim(mesh);
    return mesh;
}

std::vector<Point> random_sites(Point period, std::size_t count, std::uint64_t seed) {
    Random random(seed, count);
    std::vector<Point> sites(count);
    for (Point& p : sites) p = {period.x * random.uniform(), period.y * random.uniform()};
    return sites;
}

/// Counts the copies of sites that are strictly inside circumcircles of triangles.
std::size_t count_in_circles(const Triangulation& mesh) {
    constexpr double kMargin = 1e-6;
    const Point period = mesh.period();
    std::size_t inside = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.positions(t);
        const Point ab = b - a, ac = c - a;
        const double doubled = 2 * cross(ab, ac), ab2 = dot(ab, ab), ac2 = dot(ac, ac);
        const Point to_centre{(ac.y * ab2 - ab.y * ac2) / doubled, (ab.x * ac2 - ac.x * ab2) / doubled};
        const double radius = (1 + kMargin) * std::sqrt(dot(to_centre, to_centre)) + kMargin * std::sqrt(ab2 + ac2);
        const Point low = a + to_centre - Point{radius, radius}, high = a + to_centre + Point{radius, radius};
        for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
            const Point p = mesh.point(v);
            for (double j = std::ceil((low.y - p.y) / period.y); p.y + j * period.y <= high.y; ++j) {
                for (double i = std::ceil((low.x - p.x) / period.x); p.x + i * period.x <= high.x; ++i) {
                    const Point copy{p.x + i * period.x, p.y + j * period.y};
                    if (exact_in_circle(a, b, c, copy) > 0) ++inside;
                }
            }
        }
    }
    return inside;
}

void expect_valid(const Triangulation& mesh) {
    EXPECT_EQ(mesh.triangle_count(), 2 * mesh.site_count());
    EXPECT_EQ(mesh.vertex_count(), mesh.site_count());
    EXPECT_EQ(count_inverted(mesh), 0u);
    EXPECT_EQ(count_bad_links(mesh), 0u);
    EXPECT_EQ(count_not_delaunay(mesh), 0u);
    EXPECT_EQ(count_in_circles(mesh), 0u);
    double area = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) area += mesh.doubled_area(t) / 2;
    const double whole = mesh.period().x * mesh.period().y;
    EXPECT_NEAR(area, whole, 1e-12 * whole);
}

TEST(TorusTriangulation, IsValidForAnyNumberOfSites) {
    const Point period = period_of(1, 1);
    for (std::size_t sites = 1; sites <= 50; ++sites) {
        SCOPED_TRACE(sites);
        for (std::uint64_t seed = 0; seed < 4; ++seed) expect_valid(mesh_of(period, random_sites(period, sites, seed)));
    }
    expect_valid(mesh_of(period, random_sites(period, 3000, 1)));
}

TEST(TorusTriangulation, IsValidOnStretchedTori) {
    for (const auto& [width, height] : {std::pair{2.0, 1.0}, {1.0, 3.7}, {1.0, 30.0}, {1.0, 1000.0}, {1000.0, 1.0}}) {
        const Point period = period_of(width, height);
        for (const std::size_t sites : {1, 2, 3, 5, 10, 40, 400}) {
            SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height) + ", " + std::to_string(sites));
            expect_valid(mesh_of(period, random_sites(period, sites, 2)));
        }
    }
}

TEST(TorusTriangulation, IsValidForALattice) {
    // Groups of four cocircular sites, some of them on the seam.
    constexpr int kSide = 16;
    std::vector<Point> sites;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) sites.push_back({i / 16.0, j / 16.0});
    }
    const Triangulation mesh = mesh_of(period_of(1, 1), sites);
    expect_valid(mesh);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) EXPECT_EQ(mesh.doubled_area(t), 1.0 / 256);
}

TEST(TorusTriangulation, IsValidForSitesCrowdedAtTheSeam) {
    const Point period = period_of(1, 1);
    Random random(3, 0);
    std::vector<Point> sites;
    for (int i = 0; i < 200; ++i) {
        const double distance = std::pow(10.0, -12 * random.uniform()), angle = 6.28 * random.uniform();
        const Point p{0.4 * distance * std::cos(angle), 0.4 * distance * std::sin(angle)};
        sites.push_back({p.x - std::floor(p.x), p.y - std::floor(p.y)});
    }
    expect_valid(mesh_of(period, sites));
}

TEST(TorusTriangulation, MakesASingleSiteItsOwnNeighbour) {
    const Triangulation mesh = mesh_of(period_of(1, 1), {{0.25, 0.75}});
    ASSERT_EQ(mesh.triangle_count(), 2u);
    for (std::uint32_t t = 0; t < 2; ++t) {
        EXPECT_EQ(mesh.corners(t), (std::array<std::uint32_t, 3>{0, 0, 0}));
        EXPECT_TRUE(mesh.crosses_seam(t));
        EXPECT_EQ(mesh.doubled_area(t), 1);
    }
}

TEST(TorusTriangulation, RefusesCopiesOfAnOccupiedPosition) {
    const Point period = period_of(2, 1);
    Triangulation mesh(2, period);
    ASSERT_TRUE(insert_site(mesh, 0, {0.25, 0.125}));
    EXPECT_FALSE(insert_site(mesh, 1, {0.25, 0.125}));
    EXPECT_FALSE(insert_site(mesh, 1, {1.25, 0.125}));
    EXPECT_FALSE(insert_site(mesh, 1, {0.25, -0.375}));
    EXPECT_TRUE(insert_site(mesh, 1, {0.25, 0.125 + 0x1p-50}));
    trim(mesh);
    EXPECT_EQ(count_inverted(mesh), 0u);
    EXPECT_EQ(count_bad_links(mesh), 0u);
    EXPECT_EQ(count_not_delaunay(mesh), 0u);
}

TEST(TorusTriangulation, IsDelaunayAgainAfterMoves) {
    for (const std::size_t sites : {2, 3, 5, 20, 1000}) {
        SCOPED_TRACE(sites);
        const Point period = period_of(2, 1);
        Triangulation mesh = mesh_of(period, random_sites(period, sites, 7));
        Random random(8, sites);
        std::size_t flips = 0;
        for (int round = 0; round < 20; ++round) {
            test::stir(mesh, random);
            ASSERT_EQ(count_inverted(mesh), 0u);
            flips += restore_delaunay(mesh);
            expect_valid(mesh);
        }
        EXPECT_GT(flips, 0u);
        EXPECT_EQ(restore_delaunay(mesh), 0u);
    }
}

/// A set of sites and its shifted copy have the same triangles.
TEST(TorusTriangulation, IsInvariantUnderShifts) {
    const Point period = period_of(1, 1);
    const std::vector<Point> sites = random_sites(period, 300, 9);
    std::vector<Point> moved = sites;
    for (Point& p : moved) {
        p = snapped(p + Point{0.6171875, 0.3828125});
        p = {p.x < 1 ? p.x : p.x - 1, p.y < 1 ? p.y : p.y - 1};
    }
    const auto triangles = [](const Triangulation& mesh) {
        std::vector<std::array<std::uint32_t, 3>> all;
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
            auto corners = mesh.corners(t);
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
            all.push_back(corners);
        }
        std::sort(all.begin(), all.end());
        return all;
    };
    EXPECT_EQ(triangles(mesh_of(period, sites)), triangles(mesh_of(period, moved)));
}

}  // namespace
}  // namespace ccdt

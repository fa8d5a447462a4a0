// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface_triangulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/surface/initial_sites.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

constexpr std::size_t kSites = 600;

/// Sites drawn on a surface and triangulated, as at the start of distribute().
struct StartMesh {
    StartMesh(const TriangleSoup& soup, std::optional<double> crease, Executor& executor = inline_executor())
        : surface(Surface::create(soup, crease).value().surface),
          spacing(std::sqrt(surface.total_area() / kSites)),
          mesh(
              surface, initial_sites(surface, SurfaceDensity::uniform(), kSites, 7), 0,
              [this](const SurfacePoint&) { return spacing; },
              choose_crease_vertices(surface, std::vector<double>(surface.vertex_count(), spacing), kSites), executor) {
    }
    StartMesh(const StartMesh&) = delete;
    StartMesh& operator=(const StartMesh&) = delete;

    Surface surface;
    double spacing;
    SurfaceTriangulation mesh;
};

/// Checks the links between triangles, and that each site has a triangle. Returns vertices - edges + triangles.
std::ptrdiff_t euler_characteristic(const SurfaceTriangulation& mesh) {
    std::set<std::uint32_t> vertices;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t e = SurfaceTriangulation::edge(t, i), twin = mesh.twin(e);
            vertices.insert(mesh.origin(e));
            edges.insert(std::minmax(mesh.origin(e), mesh.target(e)));
            if (twin == SurfaceTriangulation::kNone) continue;
            EXPECT_EQ(mesh.twin(twin), e);
            EXPECT_EQ(mesh.origin(twin), mesh.target(e));
        }
    }
    EXPECT_EQ(vertices.size(), mesh.vertex_count());
    for (std::uint32_t site = 0; site < mesh.site_count(); ++site) EXPECT_EQ(mesh.origin(mesh.edge_of(site)), site);
    return static_cast<std::ptrdiff_t>(vertices.size() + mesh.triangle_count()) -
           static_cast<std::ptrdiff_t>(edges.size());
}

double area_of(const SurfaceTriangulation& mesh) {
    double doubled = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) doubled += length(mesh.doubled_normal(t));
    return doubled / 2;
}

/// Moves each site by a random part of the spacing.
void stir(StartMesh& start) {
    Random random(1, 0);
    for (std::uint32_t site = 0; site < kSites; ++site) {
        const auto off = [&] { return (random.uniform() - 0.5) * start.spacing; };
        start.mesh.move(site, {off(), off(), off()});
    }
}

TEST(SurfaceTriangulation, HasTheTopologyOfTheSurface) {
    EXPECT_EQ(euler_characteristic(StartMesh(test::sphere_surface(4), {}).mesh), 2);
    EXPECT_EQ(euler_characteristic(StartMesh(test::torus_surface(1, 0.4, 60, 30), {}).mesh), 0);
    EXPECT_EQ(euler_characteristic(StartMesh(test::square_surface(20), {}).mesh), 1);
    EXPECT_EQ(euler_characteristic(StartMesh(test::tetrahedron_surface(), {}).mesh), 2);
}

TEST(SurfaceTriangulation, RemovesTheVerticesOfTheSurface) {
    const StartMesh closed(test::sphere_surface(4), {});
    EXPECT_EQ(closed.mesh.vertex_count(), kSites);
    EXPECT_NEAR(area_of(closed.mesh), closed.surface.total_area(), 0.02 * closed.surface.total_area());
    const StartMesh flat(test::square_surface(40), {});
    EXPECT_LT(flat.mesh.vertex_count(), kSites + 120) << "only vertices along the border may remain";
    EXPECT_NEAR(area_of(flat.mesh), 1, 1e-9);
}

TEST(SurfaceTriangulation, KeepsCreases) {
    const StartMesh start(test::cube_surface(), std::numbers::pi / 6);
    std::size_t creases = 0;
    for (std::uint32_t t = 0; t < start.mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t e = SurfaceTriangulation::edge(t, i);
            if (start.mesh.twin(e) != SurfaceTriangulation::kNone) continue;
            ++creases;
            EXPECT_FALSE(start.mesh.is_site(start.mesh.origin(e)));
        }
    }
    EXPECT_GT(creases, 24U);
    EXPECT_NEAR(area_of(start.mesh), 6, 1e-9);
}

TEST(SurfaceTriangulation, IsDelaunayAfterMoves) {
    for (const TriangleSoup& soup : {test::sphere_surface(4), test::square_surface(20)}) {
        StartMesh start(soup, {});
        stir(start);
        EXPECT_GT(start.mesh.restore_delaunay(), 0U);
        EXPECT_EQ(start.mesh.restore_delaunay(), 0U);
        const auto angle_at_apex = [&](std::uint32_t e) {
            const Point3 apex = start.mesh.point(start.mesh.origin(SurfaceTriangulation::previous(e)));
            const Point3 a = start.mesh.point(start.mesh.origin(e)) - apex;
            const Point3 b = start.mesh.point(start.mesh.target(e)) - apex;
            return std::atan2(length(cross(a, b)), dot(a, b));
        };
        for (std::uint32_t t = 0; t < start.mesh.triangle_count(); ++t) {
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t e = SurfaceTriangulation::edge(t, i), twin = start.mesh.twin(e);
                if (twin == SurfaceTriangulation::kNone) continue;
                EXPECT_LE(angle_at_apex(e) + angle_at_apex(twin), std::numbers::pi + 1e-6);
            }
        }
    }
}

TEST(SurfaceTriangulation, MovesSitesAlongTheSurface) {
    StartMesh start(test::sphere_surface(4), {});
    stir(start);
    for (std::uint32_t site = 0; site < kSites; ++site) {
        const SurfacePoint& at = start.mesh.on_surface(site);
        EXPECT_LT(length(start.surface.position(at) - start.mesh.point(site)), 1e-12);
    }
    for (std::uint32_t t = 0; t < start.mesh.triangle_count(); ++t) {
        const Point3 outwards = start.mesh.point(start.mesh.corners(t)[0]) - start.surface.from_input({});
        EXPECT_GT(dot(start.mesh.doubled_normal(t), outwards), 0) << "no triangle turns over";
    }
}

TEST(SurfaceTriangulation, RelocatesASiteToATriangle) {
    StartMesh start(test::torus_surface(1, 0.4, 60, 30), {});
    const std::size_t triangles = start.mesh.triangle_count();
    // A triangle far away: one at the site with the largest distance.
    std::uint32_t farthest = 1;
    const auto distance = [&](std::uint32_t site) { return length(start.mesh.point(site) - start.mesh.point(0)); };
    for (std::uint32_t site = 1; site < kSites; ++site) {
        if (distance(site) > distance(farthest)) farthest = site;
    }
    const std::vector<std::uint32_t> target{SurfaceTriangulation::triangle_of(start.mesh.edge_of(farthest))};
    const Point3 before = start.mesh.point(0);
    ASSERT_TRUE(start.mesh.relocate(0, target));
    EXPECT_GT(length(start.mesh.point(0) - before), 4 * start.spacing);
    EXPECT_LT(distance(farthest), 3 * start.spacing);
    EXPECT_EQ(start.mesh.triangle_count(), triangles);
    EXPECT_EQ(euler_characteristic(start.mesh), 0);
}

TEST(SurfaceTriangulation, RelocatesNothingWithoutTriangles) {
    StartMesh start(test::sphere_surface(3), {});
    const Point3 before = start.mesh.point(0);
    EXPECT_FALSE(start.mesh.relocate(0, {}));
    EXPECT_EQ(start.mesh.point(0), before);
    EXPECT_EQ(euler_characteristic(start.mesh), 2);
}

TEST(SurfaceTriangulation, DoesNotDependOnThreads) {
    ThreadExecutor threads(3);
    const StartMesh one(test::torus_surface(1, 0.4, 60, 30), {});
    const StartMesh three(test::torus_surface(1, 0.4, 60, 30), {}, threads);
    ASSERT_EQ(one.mesh.triangle_count(), three.mesh.triangle_count());
    for (std::uint32_t t = 0; t < one.mesh.triangle_count(); ++t) EXPECT_EQ(one.mesh.corners(t), three.mesh.corners(t));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/distribute_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/volume/distribute_volume.h"
#include "tests/support/solids.h"

namespace ccdt {
namespace {

using test::solid_of;

VolumeDistribution distributed(const Solid& solid, const VolumeOptions& options,
                               const VoxelDensity& density = VoxelDensity::uniform()) {
    auto result = distribute_in_solid(solid, density, options);
    EXPECT_TRUE(result);
    EXPECT_EQ(result->points.size(), options.sites);
    for (const Point3 p : result->points) EXPECT_TRUE(solid.contains(p));
    return *result;
}

/// Returns the least distance of two points.
double least_distance(std::span<const Point3> points) {
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j)
            squared = std::min(squared, dot(points[j] - points[i], points[j] - points[i]));
    }
    return std::sqrt(squared);
}

double distance_to_surface(const Solid& solid, Point3 p) {
    const Surface& surface = solid.surface();
    const Point3 unit = surface.from_input(p);
    return surface.scale() * length(surface.position(surface.nearest(unit)) - unit);
}

/// Returns the share of the volume up to a depth, by random points.
double share_of_shell(const Solid& solid, double depth) {
    const Box3 box = solid.bounds();
    const Point3 sides = box.max - box.min;
    Random random(1, 0);
    double all = 0, shell = 0;
    while (all < 4000) {
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        const Point3 p = box.min + Point3{x * sides.x, y * sides.y, z * sides.z};
        if (!solid.contains(p)) continue;
        ++all;
        if (distance_to_surface(solid, p) < depth) ++shell;
    }
    return shell / all;
}

/// Returns a ball with a cavity.
TriangleSoup hollow_ball() {
    return test::joined(test::sphere_surface(3),
                        test::turned_over(test::moved(test::sphere_surface(3), 0.6, {0.1, 0.1, 0})));
}

TEST(DistributeInSolid, KeepsPointsApartAndOffTheSurface) {
    for (const TriangleSoup& soup :
         {test::sphere_surface(4), test::cube_surface(), test::torus_surface(1, 0.4, 48, 24), hollow_ball()}) {
        const Solid solid = solid_of(soup);
        const VolumeDistribution result = distributed(solid, {.sites = 2000});
        const double spacing = std::cbrt(solid.volume() / 2000);
        EXPECT_GT(least_distance(result.points), 0.8 * 1.1225 * spacing);
        std::size_t layer = 0;
        for (const Point3 p : result.points) {
            const double distance = distance_to_surface(solid, p);
            EXPECT_GT(distance, 0.3 * spacing);
            if (distance < 0.75 * spacing) ++layer;
        }
        // A layer of the densest packing is 0.917 spacings thick.
        const double expected = 2000 * share_of_shell(solid, 0.917 * spacing);
        EXPECT_NEAR(static_cast<double>(layer), expected, 0.1 * expected);
    }
}

TEST(DistributeInSolid, DividesPointsEvenlyAmongParts) {
    // A large and a small ball whose volumes differ by a factor of 8.
    const Solid solid =
        solid_of(test::joined(test::sphere_surface(3), test::moved(test::sphere_surface(3), 0.5, {3, 2, 1})));
    const auto points = distributed(solid, {.sites = 1800}).points;
    EXPECT_NEAR(static_cast<double>(std::ranges::count_if(points, [](Point3 p) { return p.x > 2; })), 200, 3);
}

TEST(DistributeInSolid, ScalesAndMovesWithTheSolid) {
    const TriangleSoup soup = test::sphere_surface(2);
    const auto points = distributed(solid_of(soup), {.sites = 200}).points;
    const auto moved = distributed(solid_of(test::moved(soup, 1024, {4096, 0, -1024})), {.sites = 200}).points;
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT(length(1024 * points[i] + Point3{4096, 0, -1024} - moved[i]), 1e-3);
}

TEST(DistributeInSolid, FollowsTheDensity) {
    // Three quarters of the points belong in the upper half of a ball, and none where x > 1/2.
    const Solid ball = solid_of(test::sphere_surface(3));
    const VoxelDensity density = *VoxelDensity::create({4, 1, 2}, std::array<double, 8>{1, 1, 1, 0, 3, 3, 3, 0});
    const auto points = distributed(ball, {.sites = 2000}, density).points;
    const auto upper = std::ranges::count_if(points, [](Point3 p) { return p.z > 0; });
    EXPECT_NEAR(static_cast<double>(upper), 1500, 30);
    for (const Point3 p : points) EXPECT_LE(p.x, 0.5);
}

TEST(DistributeInSolid, PutsTheirShareOfPointsOnBothSidesOfSteps) {
    // The planes between these voxels run through cells of the grid by which the solid is measured.
    const Solid cube = solid_of(test::cube_surface());
    for (const double low : {1e-6, 0.1}) {
        const VoxelDensity density = *VoxelDensity::create({4, 1, 1}, std::array{1.0, low, 1.0, low});
        for (const int sites : {200, 2000}) {
            const auto points = distributed(cube, {.sites = static_cast<std::size_t>(sites)}, density).points;
            const auto fewer =
                std::ranges::count_if(points, [](Point3 p) { return static_cast<int>(4 * p.x) % 2 == 1; });
            EXPECT_NEAR(static_cast<double>(fewer), sites * low / (1 + low), 2 + 0.002 * sites);
        }
    }
}

TEST(DistributeInSolid, PutsNoPointWhereTheDensityIsZero) {
    const Solid cube = solid_of(test::cube_surface());
    std::vector<double> checker;
    for (int i = 0; i < 64; ++i) checker.push_back((i + i / 4 + i / 16) % 2);
    const VoxelDensity density = *VoxelDensity::create({4, 4, 4}, checker);
    for (const int sites : {1, 20, 2000}) {
        for (const Point3 p : distributed(cube, {.sites = static_cast<std::size_t>(sites)}, density).points) {
            const auto voxel = [](double x) { return std::min(static_cast<int>(4 * x), 3); };
            EXPECT_EQ((voxel(p.x) + voxel(p.y) + voxel(p.z)) % 2, 1) << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
}

TEST(DistributeInSolid, KeepsSitesAwayFromFixedPoints) {
    VolumeOptions options{.sites = 900};
    for (int i = 0; i < 100; ++i) options.fixed.push_back({0.5, (i / 10 + 0.5) / 10, (i % 10 + 0.5) / 10});
    auto points = distributed(solid_of(test::cube_surface()), options).points;
    points.insert(points.end(), options.fixed.begin(), options.fixed.end());
    EXPECT_GT(least_distance(points), 0.074);
}

TEST(DistributeInSolid, HandlesFewPointsAndThinParts) {
    TriangleSoup plate = test::cube_surface(), rod = test::cube_surface(), needle = test::cube_surface();
    for (Point3& p : plate.vertices) p.z *= 1e-5;
    for (Point3& p : needle.vertices) p = {p.x, 1e-7 * p.y, 1e-7 * p.z};
    for (Point3& p : rod.vertices) p = {p.x, p.x + 1e-3 * p.y, p.x + 1e-3 * p.z};
    TriangleSoup pellets = test::sphere_surface(1);
    for (int i = 1; i < 40; ++i)
        pellets = test::joined(pellets, test::moved(test::sphere_surface(1), 1, {i * 7.0, i * i % 97 * 3.0, i * 2.0}));
    for (const TriangleSoup& soup : {plate, rod, needle, pellets, test::moved(hollow_ball(), 1e130, {0, 0, 0})}) {
        const Solid solid = solid_of(soup);
        for (const std::size_t sites : {1, 3, 100}) {
            const Quality quality = sites == 100 ? Quality::Standard : Quality::Draft;
            const auto result = distributed(solid, {.sites = sites, .quality = quality, .keep_mesh = true});
            EXPECT_GT(least_distance(result.points), 0);
            ASSERT_TRUE(result.mesh);
            EXPECT_LT(result.mesh->vertices.size(), 6 * sites + 1000 + soup.vertices.size());
        }
    }
}

TEST(DistributeInSolid, GivesTheSameBytesForAnyNumberOfThreads) {
    ThreadExecutor threads(3);
    std::vector<double> values;
    for (int i = 0; i < 64; ++i) values.push_back(1 + i % 5);
    const Solid ring = solid_of(test::torus_surface(1, 0.4, 48, 24));
    const VolumeOptions options{.sites = 1000, .keep_mesh = true};
    for (const VoxelDensity& density : {VoxelDensity::uniform(), *VoxelDensity::create({4, 4, 4}, values)}) {
        const auto one = distribute_in_solid(ring, density, options);
        const auto three = distribute_in_solid(ring, density, options, {.executor = &threads});
        ASSERT_TRUE(one && three);
        EXPECT_EQ(one->points, three->points);
        EXPECT_EQ(one->trace, three->trace);
        EXPECT_EQ(one->mesh->vertices, three->mesh->vertices);
        EXPECT_EQ(one->mesh->tetrahedra, three->mesh->tetrahedra);
    }
}

TEST(DistributeInSolid, FillsTheSolidWithTetrahedra) {
    for (const TriangleSoup& soup :
         {test::sphere_surface(4), test::cube_surface(), test::torus_surface(1, 0.4, 48, 24), hollow_ball()}) {
        const Solid solid = *Solid::create(std::move(Surface::create(soup, 0.8)->surface));
        const VolumeDistribution result = distributed(solid, {.sites = 1500, .keep_mesh = true});
        const TetrahedronMesh& mesh = *result.mesh;
        const double spacing = std::cbrt(solid.volume() / 1500);
        std::vector<bool> used(mesh.vertices.size(), false);
        double volume = 0;
        for (const Tetrahedron& corners : mesh.tetrahedra) {
            const auto& [a, b, c, d] = corners;
            const Point3 from = mesh.vertices[a];
            const double part =
                dot(cross(mesh.vertices[b] - from, mesh.vertices[c] - from), mesh.vertices[d] - from) / 6;
            EXPECT_GT(part, 0);
            volume += part;
            for (const std::uint32_t v : corners) used[v] = true;
        }
        EXPECT_NEAR(volume, solid.volume(), 0.03 * solid.volume());
        EXPECT_EQ(std::ranges::count(used, false), 0);
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            if (i < 1500)
                EXPECT_LT(length(mesh.vertices[i] - result.points[i]), 0.5 * spacing);
            else
                EXPECT_LT(distance_to_surface(solid, mesh.vertices[i]), 1e-6);
        }
        const auto angles = test::dihedral_angles(mesh);
        const auto flat = std::ranges::lower_bound(angles, 15.0) - angles.begin();
        EXPECT_LT(static_cast<double>(flat), 0.001 * static_cast<double>(angles.size()));
        EXPECT_GT(angles[angles.size() / 20], 37);
        if (soup.vertices.size() != 8) continue;
        // The creases and corners of the cube are kept.
        EXPECT_NEAR(volume, 1, 1e-9);
    }
}

TEST(DistributeInSolid, StopsWithTheCurrentPoints) {
    const Solid ball = solid_of(test::sphere_surface(2));
    test::expect_stops({0, 9, 19}, [&](const VolumeOptions& options, const Control& control) {
        return distribute_in_solid(ball, VoxelDensity::uniform(), options, control);
    });
}

TEST(DistributeInSolid, RejectsOptionsOutOfRange) {
    const Solid ball = solid_of(test::sphere_surface(2));
    const auto field = [&](const VoxelDensity& density, const VolumeOptions& options) {
        const auto result = distribute_in_solid(ball, density, options);
        return result ? std::string() : result.error().field;
    };
    EXPECT_EQ(field(VoxelDensity::uniform(), {.sites = 0}), "sites");
    EXPECT_EQ(field(VoxelDensity::uniform(), {.sites = 1, .fixed = {{0, 0, 0}, {0.9, 0.9, 0}}}), "fixed/1");
    // Only the corner voxel, outside the ball, has a density.
    std::vector<double> values(1000, 0);
    values.back() = 1;
    EXPECT_EQ(field(*VoxelDensity::create({10, 10, 10}, values), {.sites = 1}), "density");
}

TEST(DistributeInSolid, NamesAFixedPointOutsideTheSolid) {
    const auto result = distribute_in_solid(solid_of(test::sphere_surface(2)), VoxelDensity::uniform(),
                                            {.sites = 1, .fixed = {{0, 0, 0}, {0.9, 0.9, 0}}});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "the fixed point 1, (0.9, 0.9, 0), is not inside the solid");
}

}  // namespace
}  // namespace ccdt

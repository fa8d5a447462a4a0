// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/distribute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stop_token>
#include <string>
#include <utility>

#include "core/base/thread_executor.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/points/analysis/spacing.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

using test::bipyramid_surface;
using test::cube_surface;
using test::divided;
using test::joined;
using test::renumbered;
using test::sphere_surface;
using test::square_surface;
using test::tetrahedron_surface;
using test::torus_surface;

Surface surface_of(const TriangleSoup& soup, std::optional<double> crease = {}) {
    auto made = Surface::create(soup, crease);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(made->surface);
}

SurfaceDistribution distributed(const Surface& surface, const SurfaceOptions& options,
                                const SurfaceDensity& density = SurfaceDensity::uniform()) {
    auto result = distribute_on_surface(surface, density, options);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
}

std::vector<Point3> positions(const Surface& surface, const SurfaceDistribution& dots) {
    std::vector<Point3> all;
    for (const SurfacePoint& point : dots.points) all.push_back(surface.position(point));
    return all;
}

struct Spacing {
    double least = 0, mean = 0;
};

/// Distances of nearest neighbours in space, relative to the hexagonal distance.
Spacing spacing_of(const Surface& surface, const std::vector<Point3>& points) {
    const double hexagonal = hexagonal_spacing(static_cast<double>(points.size()) / surface.total_area());
    Spacing spacing{1e9, 0};
    for (const Point3& p : points) {
        double least = 1e9;
        for (const Point3& q : points) {
            if (&p != &q) least = std::min(least, dot(p - q, p - q));
        }
        least = std::sqrt(least) / hexagonal;
        spacing.least = std::min(spacing.least, least);
        spacing.mean += least / static_cast<double>(points.size());
    }
    return spacing;
}

/// Least distance in space of two sites on faces with normals less than 90 degrees apart, relative to the hexagonal
/// distance.
double least_of(const Surface& surface, const SurfaceDistribution& dots) {
    std::vector<Point3> normals;
    for (const SurfacePoint& point : dots.points) normals.push_back(surface.normal(point.face));
    const double sites = static_cast<double>(dots.points.size());
    return measure_spacing(positions(surface, dots), normals, {}).min / hexagonal_spacing(sites / surface.total_area());
}

/// Checks that every edge of a closed mesh belongs to two triangles of opposite direction. Returns vertices - edges +
/// triangles.
int euler_characteristic(const SurfaceMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    return static_cast<int>(mesh.vertices.size()) - static_cast<int>(edges.size() / 2) +
           static_cast<int>(mesh.triangles.size());
}

TEST(DistributeOnSurface, SpreadsSitesEvenlyOnASphere) {
    const Surface surface = surface_of(sphere_surface(4));
    for (const std::uint64_t seed : {0, 1, 2}) {
        const auto dots = distributed(surface, {.sites = 2000, .seed = seed, .keep_mesh = true});
        ASSERT_EQ(dots.points.size(), 2000U);
        const auto points = positions(surface, dots);
        const Spacing spacing = spacing_of(surface, points);
        EXPECT_GT(spacing.least, 0.77) << seed;
        EXPECT_GT(spacing.mean, 0.87) << seed;
        EXPECT_LT(dots.variation(), 0.05) << seed;
        // The centre of mass measures the longest waves. With random points, its standard deviation would be
        // sqrt(1 / 12 / 2000) in each coordinate.
        Point3 sum;
        for (const Point3& p : points) sum = sum + (p - Point3{0.5, 0.5, 0.5});
        EXPECT_LT(length(1.0 / 2000 * sum), 5e-4) << seed;
        ASSERT_TRUE(dots.mesh);
        EXPECT_EQ(dots.mesh->vertices.size(), 2000U);
        EXPECT_EQ(euler_characteristic(*dots.mesh), 2);
    }
}

/// Checks that every face of a soup, of which each is divided into `parts` faces of the surface, has its share of
/// sites, with an error of at most `tolerance` or 2 %.
void expect_shares(const TriangleSoup& soup, const Surface& surface, const SurfaceDistribution& dots, std::size_t parts,
                   double tolerance = 8) {
    std::vector<double> areas, counts(soup.triangles.size(), 0);
    for (const auto& [a, b, c] : soup.triangles) {
        const auto& v = soup.vertices;
        areas.push_back(length(cross(v[b] - v[a], v[c] - v[a])));
    }
    for (const SurfacePoint& point : dots.points) ++counts[surface.triangle_of(point.face) / parts];
    const double all = std::accumulate(areas.begin(), areas.end(), 0.0);
    for (std::size_t f = 0; f < areas.size(); ++f) {
        const double share = areas[f] / all * static_cast<double>(dots.points.size());
        EXPECT_NEAR(counts[f], share, std::max(tolerance, 0.02 * share)) << "face " << f;
    }
}

TEST(DistributeOnSurface, DependsNeitherOnNumbersNorOnTheSizeOfFaces) {
    struct Case {
        const char* name;
        TriangleSoup soup;
        std::optional<double> crease = {};
    };
    const Case cases[] = {
        {"triangle", {.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 8, 0}}, .triangles = {{0, 1, 2}}}},
        {"square", square_surface(1)},
        {"tetrahedron", tetrahedron_surface()},
        {"tetrahedron with creases", tetrahedron_surface(), 0.5},
        {"cube", cube_surface()},
        {"cube with creases", cube_surface(), 0.5},
        {"octahedron", bipyramid_surface(4, 1)},
        {"icosahedron", sphere_surface(0)},
        {"triangular bipyramid", bipyramid_surface(3, 1.2)},
        {"flat bipyramid", bipyramid_surface(6, 0.4)},
        {"prism", test::needle_prism(3)},
    };
    for (const auto& [name, soup, crease] : cases) {
        for (const int turns : {0, 1, 2}) {
            for (const int count : {1, 12}) {
                SCOPED_TRACE(std::string(name) + ", turned " + std::to_string(turns) + ", divided by " +
                             std::to_string(count));
                const TriangleSoup turned = renumbered(soup, turns);
                const Surface surface = surface_of(divided(turned, count), crease);
                const auto dots = distributed(surface, {.sites = 5000, .seed = 2, .keep_mesh = true});
                expect_shares(turned, surface, dots, static_cast<std::size_t>(count) * static_cast<std::size_t>(count));
                EXPECT_LT(dots.variation(), 0.2);
                // Rounding decides about pairs on faces whose normals are exactly 90 degrees apart.
                EXPECT_GT(least_of(surface, dots), crease ? 0 : 0.6);
                if (surface.border_edges() == 0) {
                    EXPECT_EQ(euler_characteristic(*dots.mesh), 2);
                }
            }
        }
    }
}

TriangleSoup stretched(TriangleSoup soup, Point3 by) {
    for (Point3& p : soup.vertices) p = {by.x * p.x, by.y * p.y, by.z * p.z};
    return soup;
}

TEST(DistributeOnSurface, GivesTheFacesOfNeedlesAndPlatesTheirShares) {
    const std::pair<const char*, TriangleSoup> cases[] = {
        {"needle", stretched(tetrahedron_surface(), {10, 1, 1})},
        {"thin needle", stretched(tetrahedron_surface(), {1, 30, 1})},
        {"double disc", bipyramid_surface(5, 0.01)},
        {"long bipyramid", bipyramid_surface(7, 10)},
    };
    for (const auto& [name, soup] : cases) {
        for (const int count : {1, 9}) {
            SCOPED_TRACE(std::string(name) + ", divided by " + std::to_string(count));
            const Surface surface = surface_of(divided(soup, count));
            const auto dots = distributed(surface, {.sites = 3000, .seed = 1});
            expect_shares(soup, surface, dots, static_cast<std::size_t>(count) * static_cast<std::size_t>(count), 15);
            EXPECT_LT(dots.variation(), 0.2);
        }
    }
}

/// Returns a surface of length 12 with pointed ends, of radius 1 in the middle.
/// @param open  share of the length that is cut off at both ends
TriangleSoup spindle_surface(int columns, int rows, double open = 0) {
    return test::grid_surface(columns, rows, [open](double u, double v) {
        v = open + (1 - 2 * open) * v;
        const double angle = u < 1 ? 2 * std::numbers::pi * u : 0, radius = std::pow(1 - std::abs(2 * v - 1), 3);
        return Point3{radius * std::cos(angle), radius * std::sin(angle), 12 * v};
    });
}

TEST(DistributeOnSurface, KeepsSitesApartAtThinTips) {
    const std::pair<const char*, TriangleSoup> cases[] = {
        {"bipyramid", bipyramid_surface(7, 10)},
        {"triangular bipyramid of small faces", divided(bipyramid_surface(3, 10), 20)},
        {"spindle", spindle_surface(24, 80)},
    };
    for (const auto& [name, soup] : cases) {
        const Surface surface = surface_of(soup);
        for (const std::uint64_t seed : {0, 1, 2, 3, 4}) {
            SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
            const auto dots = distributed(surface, {.sites = 1000, .seed = seed, .keep_mesh = true});
            EXPECT_GT(least_of(surface, dots), 0.7);
            EXPECT_LT(dots.variation(), 0.15);
            EXPECT_EQ(euler_characteristic(*dots.mesh), 2);
        }
    }
}

TEST(DistributeOnSurface, KeepsSitesApartAtThinTipsThatAreOpen) {
    const Surface surfaces[] = {surface_of(spindle_surface(12, 40, 0.2)), surface_of(spindle_surface(24, 60, 0.15))};
    for (const Surface& surface : surfaces) {
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            SCOPED_TRACE(std::to_string(surface.face_count()) + " faces, seed " + std::to_string(seed));
            const auto dots = distributed(surface, {.sites = 300, .seed = seed});
            EXPECT_GT(least_of(surface, dots), 0.7);
            EXPECT_LT(dots.variation(), 0.2);
        }
    }
}

TEST(DistributeOnSurface, KeepsSitesApartInStripsOfOneOrTwoRows) {
    constexpr std::size_t kSites = 200;
    const double row = hexagonal_spacing(1);
    for (const double width : {1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 2.0, 2.2}) {
        // Three quarters of a circle, of the area 1 for each site.
        const double length = static_cast<double>(kSites) / (width * row), radius = length / (1.5 * std::numbers::pi);
        const Surface surface = surface_of(test::grid_surface(40, 1, [&](double u, double v) {
            const double angle = 1.5 * std::numbers::pi * u;
            return Point3{radius * std::cos(angle), radius * std::sin(angle), width * row * v};
        }));
        for (const std::uint64_t seed : {0, 1, 2}) {
            SCOPED_TRACE(std::to_string(width) + " hexagonal spacings wide, seed " + std::to_string(seed));
            const auto dots = distributed(surface, {.sites = kSites, .seed = seed});
            EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.45);
        }
    }
}

TEST(DistributeOnSurface, FollowsThinTubesOfSmallFaces) {
    // The circumference is 5.5 hexagonal spacings.
    constexpr std::size_t kSites = 346;
    for (const auto& [columns, rows] : {std::pair(96, 16), std::pair(192, 32)}) {
        const Surface surface = surface_of(torus_surface(1, 0.1, columns, rows));
        for (const std::uint64_t seed : {0, 1, 2, 3, 4}) {
            SCOPED_TRACE(std::to_string(columns) + " columns, seed " + std::to_string(seed));
            const auto dots = distributed(surface, {.sites = kSites, .seed = seed});
            EXPECT_LT(dots.variation(), 0.1);
            EXPECT_GT(least_of(surface, dots), 0.7);
        }
    }
}

TEST(DistributeOnSurface, FollowsThinTubesBesideComponentsWithSharpEdges) {
    // The circumference is 4.6 hexagonal spacings.
    const Surface surface = surface_of(joined(torus_surface(1, 0.1, 192, 32), test::cube_surface({3, 3, 3}, 0.5)));
    for (const std::uint64_t seed : {0, 1, 2, 3, 4}) {
        SCOPED_TRACE(seed);
        EXPECT_LT(distributed(surface, {.sites = 337, .seed = seed}).variation(), 0.1);
    }
}

TEST(DistributeOnSurface, SpreadsSitesEvenlyOverLongThinFaces) {
    // A tube of needles: each quarter of its length has a quarter of the sites.
    for (const int sides : {40, 400, 4000}) {
        SCOPED_TRACE(sides);
        const Surface surface = surface_of(test::grid_surface(sides, 1, [](double u, double v) {
            const double angle = u < 1 ? 2 * std::numbers::pi * u : 0;
            return Point3{std::cos(angle), std::sin(angle), 8 * v};
        }));
        const auto dots = distributed(surface, {.sites = 2000});
        EXPECT_LT(dots.variation(), 0.1);
        std::array<double, 4> counts{};
        for (const Point3& p : positions(surface, dots)) ++counts[static_cast<std::size_t>(std::min(4 * p.z, 3.0))];
        for (const double count : counts) EXPECT_NEAR(count, 500, 15);
    }
}

TEST(DistributeOnSurface, SeparatesSitesInSpaceAcrossSharpEdges) {
    for (const TriangleSoup& soup : {tetrahedron_surface(), bipyramid_surface(3, 1)}) {
        const Surface surface = surface_of(soup);
        const auto dots = distributed(surface, {.sites = 3000});
        EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.58);
        EXPECT_LT(dots.variation(), 0.06);
    }
}

TEST(DistributeOnSurface, ReturnsADelaunayMeshAfterEveryNumberOfIterations) {
    const Surface surface = surface_of(sphere_surface(3));
    for (const int iterations : {0, 1, 5}) {
        const auto dots = distributed(
            surface, {.sites = 2000, .iterations = iterations, .quality = Quality::Draft, .keep_mesh = true});
        std::map<std::pair<std::uint32_t, std::uint32_t>, double> angles;  // sums of the angles opposite to the edges
        for (const auto& t : dots.mesh->triangles) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = t[i], b = t[(i + 1) % 3];
                const Point3 apex = dots.mesh->vertices[t[(i + 2) % 3]];
                const Point3 to_a = dots.mesh->vertices[a] - apex, to_b = dots.mesh->vertices[b] - apex;
                angles[std::minmax(a, b)] += std::atan2(length(cross(to_a, to_b)), dot(to_a, to_b));
            }
        }
        for (const auto& [edge, sum] : angles) EXPECT_LE(sum, std::numbers::pi + 1e-6) << iterations;
    }
}

TEST(DistributeOnSurface, KeepsTheTopologyOfATorus) {
    const Surface surface = surface_of(torus_surface(2, 0.7, 60, 30));
    for (const std::size_t sites : {200, 1500, 6000}) {
        const auto dots = distributed(surface, {.sites = sites, .keep_mesh = true});
        EXPECT_EQ(euler_characteristic(*dots.mesh), 0) << sites;
        EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.7) << sites;
    }
}

TEST(DistributeOnSurface, DoesNotDependOnTheNumberOfThreads) {
    const Surface surface = surface_of(torus_surface(2, 0.7, 60, 30));
    const SurfaceOptions options{.sites = 10'000, .seed = 5, .keep_mesh = true};
    const auto one = distributed(surface, options);
    ThreadExecutor executor(3);
    Control control;
    control.executor = &executor;
    const auto three = distribute_on_surface(surface, SurfaceDensity::uniform(), options, control);
    ASSERT_TRUE(three);
    EXPECT_EQ(positions(surface, one), positions(surface, *three));
    EXPECT_EQ(one.mesh->triangles, three->mesh->triangles);
}

TEST(DistributeOnSurface, GivesComponentsTheirShares) {
    TriangleSoup large = sphere_surface(3);
    TriangleSoup small = sphere_surface(3);
    for (Point3& p : small.vertices) p = 0.5 * p + Point3{5, 0, 0};
    const Surface surface = surface_of(joined(large, small));
    ASSERT_EQ(surface.component_count(), 2U);
    const auto dots = distributed(surface, {.sites = 1000});
    const auto of_large = std::ranges::count_if(
        dots.points, [&](const SurfacePoint& point) { return surface.to_input(surface.position(point)).x < 2; });
    EXPECT_EQ(of_large, 800);
}

TEST(DistributeOnSurface, SpreadsFewSitesOverManyComponents) {
    TriangleSoup soup;
    for (int i = 0; i < 100; ++i) soup = joined(std::move(soup), cube_surface({2.0 * (i % 10), 2.0 * (i / 10), 0}, 1));
    const Surface surface = surface_of(soup);
    ASSERT_EQ(surface.component_count(), 100U);
    const auto dots = distributed(surface, {.sites = 40});
    std::array<int, 2> south{}, west{};
    for (const SurfacePoint& point : dots.points) {
        const Point3 position = surface.to_input(surface.position(point));
        ++west[position.x < 9.5 ? 0 : 1];
        ++south[position.y < 9.5 ? 0 : 1];
    }
    for (const auto& counts : {south, west}) EXPECT_NEAR(counts[0], 20, 1);
}

TEST(DistributeOnSurface, SeparatesSitesWhereSurfacesIntersect) {
    TriangleSoup other = sphere_surface(4);
    for (Point3& p : other.vertices) p = p + Point3{1.2, 0.5, 0};
    const Surface surface = surface_of(joined(sphere_surface(4), other));
    for (const std::uint64_t seed : {0, 1}) {
        const auto dots = distributed(surface, {.sites = 2000, .seed = seed});
        std::vector<Point3> normals;
        for (const SurfacePoint& point : dots.points) normals.push_back(surface.normal(point.face));
        const double least = measure_spacing(positions(surface, dots), normals, {}).min;
        EXPECT_GE(least / hexagonal_spacing(2000 / surface.total_area()), 0.8) << seed;
    }
}

TEST(DistributeOnSurface, SpreadsSitesOnEachOfParallelSheets) {
    const TriangleSoup sheet = square_surface(8);
    TriangleSoup all = sheet;
    constexpr int kSheets = 3;
    for (int i = 1; i < kSheets; ++i) {
        TriangleSoup other = sheet;
        for (Point3& p : other.vertices) p.z += 1e-3 * i;
        all = joined(all, other);
    }
    const Surface surface = surface_of(all);
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const auto dots = distributed(surface, {.sites = 500 * kSheets, .seed = seed});
        std::array<std::vector<Point3>, kSheets> points;
        for (const Point3& p : positions(surface, dots))
            points[static_cast<std::size_t>(std::lround(1e3 * p.z))].push_back(p);
        for (const auto& own : points) {
            ASSERT_EQ(own.size(), 500U);
            double least = 1e9;
            for (const Point3& p : own) {
                for (const Point3& q : own) {
                    if (&p != &q) least = std::min(least, length(p - q));
                }
            }
            EXPECT_GT(least / hexagonal_spacing(500), 0.7) << seed;
        }
    }
}

TEST(DistributeOnSurface, KeepsHalfARowFromABorder) {
    const Surface surface = surface_of(square_surface(1));
    const auto dots = distributed(surface, {.sites = 1000, .keep_mesh = true});
    const double row = hexagonal_spacing(1000) * std::sqrt(3.0) / 2;
    double least = 1;
    int first_row = 0;
    for (const Point3& p : positions(surface, dots)) {
        const double off = std::min({p.x, 1 - p.x, p.y, 1 - p.y});
        least = std::min(least, off);
        first_row += off < row;
    }
    EXPECT_GT(least, 0.35 * row);
    EXPECT_LT(least, 0.6 * row);
    // The expected number of sites in the area within a row of the border.
    EXPECT_NEAR(first_row, 1000 * (1 - std::pow(1 - 2 * row, 2)), 12);
    EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.74);
    double area = 0;
    for (const auto& [a, b, c] : dots.mesh->triangles) {
        const auto& v = dots.mesh->vertices;
        area += length(cross(v[b] - v[a], v[c] - v[a])) / 2;
    }
    EXPECT_NEAR(area, 1, 1e-9);
}

TEST(DistributeOnSurface, KeepsCreases) {
    const Surface surface = surface_of(cube_surface(), 0.7);
    ASSERT_EQ(surface.component_count(), 6U);
    const auto dots = distributed(surface, {.sites = 600, .keep_mesh = true});
    std::vector<int> counts(6, 0);
    for (const SurfacePoint& point : dots.points) ++counts[surface.component(point.face)];
    EXPECT_EQ(counts, std::vector<int>(6, 100));
    double area = 0, volume = 0;
    for (const auto& [a, b, c] : dots.mesh->triangles) {
        const auto& v = dots.mesh->vertices;
        area += length(cross(v[b] - v[a], v[c] - v[a])) / 2;
        volume += dot(v[a], cross(v[b], v[c])) / 6;
    }
    EXPECT_NEAR(area, 6, 1e-9);
    EXPECT_NEAR(volume, 1, 1e-9);
    EXPECT_EQ(euler_characteristic(*dots.mesh), 2);
}

TEST(DistributeOnSurface, DividesAllEdgesOfAFaceForEveryFirstCorner) {
    const TriangleSoup triangle{.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 8, 0}}, .triangles = {{0, 1, 2}}};
    for (const int turns : {0, 1, 2}) {
        for (const TriangleSoup& soup : {triangle, square_surface(1)}) {
            const Surface surface = surface_of(renumbered(soup, turns));
            const auto dots = distributed(surface, {.sites = 1000});
            EXPECT_LT(dots.variation(), 0.1) << turns;
            EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.7) << turns;
        }
        const Surface cube = surface_of(renumbered(cube_surface(), turns), 0.5);
        const auto dots = distributed(cube, {.sites = 2000, .keep_mesh = true});
        EXPECT_LT(dots.variation(), 0.1) << turns;
        EXPECT_EQ(euler_characteristic(*dots.mesh), 2) << turns;
        std::vector<int> counts(12, 0);
        for (const SurfacePoint& point : dots.points) ++counts[cube.triangle_of(point.face)];
        for (const int count : counts) EXPECT_NEAR(count, 2000.0 / 12, 5) << turns;
    }
}

TEST(DistributeOnSurface, FollowsADensity) {
    const TriangleSoup soup = square_surface(16);
    const Surface surface = surface_of(soup);
    std::vector<double> values;
    for (const Point3& p : soup.vertices) values.push_back(p.x);
    const auto density = SurfaceDensity::of_vertices(surface, soup, values);
    ASSERT_TRUE(density);
    const auto dots = distributed(surface, {.sites = 4000}, *density);
    for (const double until : {0.25, 0.5, 0.75}) {
        const auto count = std::ranges::count_if(
            dots.points, [&](const SurfacePoint& point) { return surface.position(point).x < until; });
        EXPECT_NEAR(static_cast<double>(count), 4000 * until * until, 30) << until;
    }
}

TEST(DistributeOnSurface, KeepsSitesAwayFromFixedPoints) {
    const Surface surface = surface_of(sphere_surface(4));
    SurfaceOptions options{.sites = 500};
    options.fixed = {{1, 0, 0}, {0, 1.2, 0}, {0, 0, -0.5}, {0.999, 0.001, 0}};
    const auto dots = distributed(surface, options);
    ASSERT_EQ(dots.points.size(), 500U);
    const double hexagonal = hexagonal_spacing(503 / surface.total_area());
    for (const Point3 fixed : {Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{0, 0, -1}}) {
        double least = 1;
        for (const Point3& p : positions(surface, dots)) least = std::min(least, length(p - surface.from_input(fixed)));
        EXPECT_GT(least / hexagonal, 0.7);
        EXPECT_LT(least / hexagonal, 1.3);
    }
}

TEST(DistributeOnSurface, AcceptsFewSites) {
    for (const TriangleSoup& soup :
         {sphere_surface(0), sphere_surface(3), cube_surface(), square_surface(1), torus_surface(2, 0.7, 20, 10)}) {
        const Surface surface = surface_of(soup);
        for (std::size_t sites = 1; sites < 12; ++sites) {
            const auto dots = distributed(surface, {.sites = sites, .keep_mesh = true});
            EXPECT_EQ(dots.points.size(), sites);
            EXPECT_TRUE(std::isfinite(dots.variation()));
        }
    }
}

TEST(DistributeOnSurface, AcceptsManyFacesForFewSites) {
    const Surface surface = surface_of(sphere_surface(6));
    ASSERT_EQ(surface.face_count(), 81'920U);
    const auto dots = distributed(surface, {.sites = 300, .keep_mesh = true});
    EXPECT_EQ(euler_characteristic(*dots.mesh), 2);
    EXPECT_EQ(dots.mesh->vertices.size(), 300U);
    EXPECT_GT(spacing_of(surface, positions(surface, dots)).least, 0.75);
}

TEST(DistributeOnSurface, StopsEarly) {
    const Surface surface = surface_of(sphere_surface(4));
    std::stop_source source;
    Control control;
    control.stop = source.get_token();
    control.progress = [&](const Progress& progress) {
        EXPECT_LE(progress.iteration, 2);
        if (progress.iteration == 2) source.request_stop();
    };
    const auto dots = distribute_on_surface(surface, SurfaceDensity::uniform(), {.sites = 5000}, control);
    ASSERT_TRUE(dots);
    EXPECT_TRUE(dots->stopped);
    EXPECT_EQ(dots->iterations, 2);
    EXPECT_EQ(dots->points.size(), 5000U);
    const auto none = distribute_on_surface(surface, SurfaceDensity::uniform(), {.sites = 5000}, control);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, ErrorCode::Stopped);
}

TEST(DistributeOnSurface, RefusesADensityOfZero) {
    const TriangleSoup soup = joined(square_surface(2), {});
    const Surface surface = surface_of(soup);
    const std::vector<double> values(soup.vertices.size(), 0);
    const auto density = SurfaceDensity::of_vertices(surface, soup, values);
    EXPECT_EQ(distribute_on_surface(surface, *density, {.sites = 5}).error().code, ErrorCode::Unusable);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::grid_of;
using test::StartMesh;

Domain torus(double width, double height) {
    return Domain::torus(width, height).value();
}

Density noise() {
    Random random(1, 0);
    return grid_of(17, 11, [&](int, int) { return random.uniform() < 0.2 ? 0.0 : 0.1 + random.uniform(); });
}

Density hills(int shift) {
    return grid_of(96, 64, [&](int i, int j) {
        const double x = 6.283185307179586 * (i + shift) / 96, y = 6.283185307179586 * j / 64;
        return 1.3 + std::sin(x) + 0.2 * std::cos(2 * y);
    });
}

double sum_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

using Corners = std::vector<Point>;

/// Clips a convex polygon to axis . p <= level.
Corners clipped(const Corners& polygon, Point axis, double level) {
    Corners kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const double over_a = dot(axis, a) - level, over_b = dot(axis, b) - level;
        if (over_a <= 0) kept.push_back(a);
        if ((over_a < 0 && over_b > 0) || (over_a > 0 && over_b < 0)) {
            kept.push_back(a + (over_a / (over_a - over_b)) * (b - a));
        }
    }
    return kept;
}

double area_of(const Corners& polygon) {
    double doubled = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) doubled += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
    return doubled / 2;
}

/// Integrates a periodic density over a triangle, in cells, by clipping the triangle to each cell.
double integral(const Density& density, const std::array<Point, 3>& triangle) {
    const auto range = [&](double Point::*axis) {
        const auto [low, high] = std::minmax({triangle[0].*axis, triangle[1].*axis, triangle[2].*axis});
        return std::pair{static_cast<int>(std::floor(low)), static_cast<int>(std::ceil(high))};
    };
    const auto wrapped = [](int i, int period) { return ((i % period) + period) % period; };
    const auto [left, right] = range(&Point::x);
    const auto [bottom, top] = range(&Point::y);
    double sum = 0;
    for (int j = bottom; j < top; ++j) {
        for (int i = left; i < right; ++i) {
            Corners cell(triangle.begin(), triangle.end());
            cell = clipped(clipped(cell, {1, 0}, i + 1), {-1, 0}, -i);
            cell = clipped(clipped(cell, {0, 1}, j + 1), {0, -1}, -j);
            sum += area_of(cell) * density.value(wrapped(i, density.width()), wrapped(j, density.height()));
        }
    }
    return sum;
}

void expect_exact(StartMesh& start) {
    start.measure();
    const Triangulation& mesh = start.mesh;
    const Point sides = mesh.period();
    const double total = start.density.total();
    std::size_t crossing = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        auto positions = mesh.positions(t);
        for (Point& p : positions) p = {p.x / sides.x * start.density.width(), p.y / sides.y * start.density.height()};
        crossing += mesh.crosses_seam(t) ? 1 : 0;
        ASSERT_NEAR(start.capacities[t], integral(start.density, positions), 1e-11 * total) << t;
    }
    EXPECT_GT(crossing, 0u);
    EXPECT_NEAR(sum_of(start.capacities), total, 1e-11 * total);
    EXPECT_NEAR(start.capacity.total(), total, 1e-12 * total);
}

TEST(TorusCapacity, IsTheIntegralOfTheRepeatedDensity) {
    for (const Domain& domain : {torus(1, 1), torus(3, 2), torus(1, 30)}) {
        for (const std::size_t sites : {1, 2, 3, 20, 300}) {
            SCOPED_TRACE(sites);
            StartMesh start(domain, noise(), {.sites = sites, .seed = sites});
            expect_exact(start);
        }
    }
}

TEST(TorusCapacity, AcceptsSitesOutsideTheBox) {
    StartMesh start(torus(2, 1), noise(), {.sites = 50, .seed = 1});
    for (const Point by : {Point{0.375, -0.25}, Point{-1, 0.4375}, Point{0.28125, 0.71875}}) {
        for (Point& p : start.mesh.points()) p = p + by;
        expect_exact(start);
    }
}

TEST(TorusCapacity, IsTheAreaForAUniformDensity) {
    StartMesh start(torus(5, 2), Density::uniform(), {.sites = 100});
    start.measure();
    for (std::uint32_t t = 0; t < start.mesh.triangle_count(); ++t) {
        EXPECT_DOUBLE_EQ(start.capacities[t], start.mesh.doubled_area(t) / 2);
    }
    EXPECT_NEAR(sum_of(start.capacities), 0.4, 1e-14);
}

Distribution run(const Domain& domain, const Density& density, const Options& options) {
    return distribute(domain, density, options).value();
}

constexpr std::array kQualities = {Quality::Draft, Quality::Standard, Quality::Best};

TEST(TorusDistribute, PlacesDistinctSitesInTheBox) {
    Random random(2, 0);
    const std::vector<Density> densities{
        Density::uniform(), noise(), hills(0), grid_of(64, 64, [](int i, int) { return i < 32 ? 0.0 : 1.0; }),
        grid_of(9, 9, [&](int, int) { return std::pow(10.0, 24 * random.uniform() - 12); })};
    for (const Domain& domain : {torus(1, 1), torus(2, 1), torus(1e-6, 7e-6), torus(1000, 1), torus(1e9, 1e9)}) {
        const Point sides = domain.bounds().max;
        for (std::size_t d = 0; d < densities.size(); ++d) {
            for (const std::size_t sites : {1, 2, 3, 4, 10, 300}) {
                for (const Quality quality : kQualities) {
                    const Options options{.sites = sites, .seed = sites, .quality = quality, .keep_mesh = true};
                    const auto result = run(domain, densities[d], options);
                    ASSERT_EQ(result.points.size(), sites);
                    for (const Point p : result.points) {
                        ASSERT_TRUE(p.x >= 0 && p.x < sides.x && p.y >= 0 && p.y < sides.y) << p.x << ' ' << p.y;
                    }
                    EXPECT_EQ(test::count_distinct(result.points), sites) << "density " << d;
                    EXPECT_TRUE(std::isfinite(result.variation()));
                    EXPECT_EQ(result.mesh->triangles.size(), 2 * sites);
                    EXPECT_EQ(result.mesh->vertices, result.points);
                    EXPECT_TRUE(result.mesh->boundary.empty());
                }
            }
        }
    }
}

TEST(TorusDistribute, LowersTheVariation) {
    const Options options{.sites = 4096, .seed = 1, .quality = Quality::Draft};
    const auto uniform = run(torus(1, 1), Density::uniform(), options);
    EXPECT_GT(uniform.trace.front(), 0.5);
    EXPECT_LT(uniform.variation(), 0.06);
    EXPECT_LT(run(torus(3, 2), hills(0), options).variation(), 0.08);
}

TEST(TorusDistribute, IsDeterministicForASeed) {
    for (const Quality quality : kQualities) {
        for (const Density& density : {Density::uniform(), hills(0)}) {
            const Options options{.sites = 800, .seed = 4, .quality = quality};
            const auto points = run(torus(3, 2), density, options).points;
            EXPECT_EQ(points, run(torus(3, 2), density, options).points);
            EXPECT_NE(points, run(torus(3, 2), density, {.sites = 800, .seed = 5, .quality = quality}).points);
        }
    }
}

/// Returns the distance of each point to its nearest neighbour on the torus.
std::vector<double> nearest_distances(const std::vector<Point>& points, Point sides) {
    std::vector<double> distances;
    for (const Point p : points) {
        double nearest = sides.x + sides.y;
        for (const Point q : points) {
            if (p == q) continue;
            const Point d{std::remainder(q.x - p.x, sides.x), std::remainder(q.y - p.y, sides.y)};
            nearest = std::min(nearest, std::sqrt(dot(d, d)));
        }
        distances.push_back(nearest);
    }
    return distances;
}

TEST(TorusDistribute, HasNoSeam) {
    constexpr std::size_t kSites = 1024;
    constexpr double kSpacing = 1.0 / 32, kStrip = 1.5 * kSpacing;
    const double strip_share = 1 - (1 - 2 * kStrip) * (1 - 2 * kStrip);
    for (const Quality quality : kQualities) {
        double near_sum = 0, far_sum = 0, near_count = 0, far_count = 0;
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            const auto points =
                run(torus(1, 1), Density::uniform(), {.sites = kSites, .seed = seed, .quality = quality}).points;
            const auto distances = nearest_distances(points, {1, 1});
            for (std::size_t i = 0; i < kSites; ++i) {
                const auto [x, y] = points[i];
                const bool near = std::min({x, 1 - x, y, 1 - y}) < kStrip;
                (near ? near_sum : far_sum) += distances[i];
                (near ? near_count : far_count) += 1;
            }
        }
        EXPECT_NEAR(near_sum / near_count, far_sum / far_count, 0.02 * kSpacing);
        EXPECT_NEAR(near_count / (near_count + far_count), strip_share, 0.02 * strip_share);
    }
}

/// A shift of the density by half a period shifts the sites and keeps their quality.
TEST(TorusDistribute, ShiftsWithItsDensity) {
    constexpr std::uint64_t kSeeds = 4;
    for (const Quality quality : kQualities) {
        double variation = 0, moved_variation = 0, x = 0, moved_x = 0;
        for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
            const Options options{.sites = 1000, .seed = seed, .quality = quality};
            const auto set = run(torus(3, 2), hills(0), options), moved = run(torus(3, 2), hills(48), options);
            variation += set.variation() / kSeeds;
            moved_variation += moved.variation() / kSeeds;
            for (const Point p : set.points) x += std::sin(6.283185307179586 * p.x / 3) / (kSeeds * 1000);
            for (const Point p : moved.points) moved_x += std::sin(6.283185307179586 * p.x / 3) / (kSeeds * 1000);
        }
        EXPECT_NEAR(variation, moved_variation, 0.15 * variation);
        // The mean of a sine, weighted by a density of 1.3 plus that sine.
        EXPECT_NEAR(x, 0.5 / 1.3, 0.01);
        EXPECT_NEAR(moved_x, -0.5 / 1.3, 0.01);
    }
}

}  // namespace
}  // namespace ccdt

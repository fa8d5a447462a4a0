// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/progressive_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "core/base/random.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/globe/chart.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/volume/distribute_volume.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/points/analysis/analysis.h"
#include "core/points/order/reorder.h"
#include "tests/support/evenness.h"

namespace ccdt {
namespace {

std::vector<Point> distributed(const Domain& domain, const Density& density, std::size_t sites, std::uint64_t seed) {
    Options options;
    options.sites = sites;
    options.seed = seed;
    return distribute(domain, density, options)->points;
}

std::vector<Point> first_of(const std::vector<Point>& points, const std::vector<std::uint32_t>& order, std::size_t k) {
    std::vector<Point> first;
    for (std::size_t i = 0; i < k; ++i) first.push_back(points[order[i]]);
    return first;
}

bool is_permutation(std::vector<std::uint32_t> order, std::size_t count) {
    std::ranges::sort(order);
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0U);
    return order == all;
}

/// Random points have a mean distance of 0.47, and a power of 1.
TEST(ProgressiveOrder, SpreadsAnyNumberOfFirstPoints) {
    const Domain torus = *Domain::torus(1, 1);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const auto points = distributed(torus, Density::uniform(), 8'192, seed);
        const auto order = progressive_order(torus, points, true);
        ASSERT_TRUE(is_permutation(order, points.size()));
        for (std::size_t k = 256; k < points.size(); k += k / 7) {
            const std::vector<std::vector<Point>> sets = {first_of(points, order, k)};
            const Analysis first = *analyse(sets, torus, {.max_frequency = 1});
            EXPECT_GT(first.min_distance, 0.5799) << seed << ' ' << k;
            EXPECT_GT(first.mean_distance, 0.71) << seed << ' ' << k;
            EXPECT_LT(*first.low_frequency_power, 0.13) << seed << ' ' << k;
        }
    }
}

TEST(ProgressiveOrder, KeepsAnyNumberOfFirstPointsApart) {
    const std::vector<PolygonPart> shape = {{{{0, 0}, {4, 0}, {4, 3}, {2, 1}, {0, 3}}, {}}};
    for (const Domain& domain : {*Domain::torus(1, 1), *Domain::rectangle(2, 1), *Domain::create(shape)}) {
        for (const Quality quality : {Quality::Standard, Quality::Best}) {
            Options options;
            options.sites = 4'096;
            options.quality = quality;
            const auto points = distribute(domain, Density::uniform(), options)->points;
            const auto order = progressive_order(domain, points, true);
            for (std::size_t k = 2; k <= points.size(); k += 1 + k / 50)
                EXPECT_GT(test::sorted_distances(domain, first_of(points, order, k)).front(), 0.579) << k;
        }
    }
}

TEST(ProgressiveOrder, IsIdenticalOnAnyNumberOfThreads) {
    constexpr std::size_t kPoints = 20'000;  // enough for several tasks
    Random random(4, 0);
    std::vector<Point> points(kPoints);
    for (Point& p : points) p = {random.uniform() * random.uniform(), random.uniform()};
    for (const Domain& domain : {Domain::torus(1, 1).value(), Domain::rectangle(1, 1).value()}) {
        for (const bool even : {true, false}) {
            const auto order = progressive_order(domain, points, even);
            for (const std::size_t size : {2, 16}) {
                ThreadExecutor executor(size);
                EXPECT_EQ(progressive_order(domain, points, even, {}, executor), order);
            }
        }
    }
}

TEST(ProgressiveOrder, SuppressesLongWaves) {
    const Domain square = *Domain::rectangle(1, 1);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const auto points = distributed(square, Density::uniform(), 8'192, seed);
        const auto order = progressive_order(square, points, true);
        for (std::size_t k = 128; k < points.size(); k += k / 3)
            EXPECT_LT(test::noise(square, first_of(points, order, k), 2), -12.5) << seed << ' ' << k;
    }
}

TEST(ProgressiveOrder, FollowsTheDensity) {
    constexpr std::array<double, 4> kValues = {1, 6, 2, 3};
    const Domain square = *Domain::rectangle(1, 1);
    const Density density = *Density::grid(2, 2, std::span<const double>(kValues));
    const auto points = distributed(square, density, 4'096, 5);
    const auto order = progressive_order(square, points, false);
    for (std::size_t k = 64; k <= points.size(); k *= 2) {
        std::array<double, 4> counts{};
        for (const Point p : first_of(points, order, k)) counts[(p.y < 0.5 ? 0 : 2) + (p.x < 0.5 ? 0 : 1)] += 1;
        for (std::size_t i = 0; i < 4; ++i) {
            const double wanted = kValues[i] / 12 * static_cast<double>(k);
            EXPECT_NEAR(counts[i], wanted, 3 + 0.08 * wanted) << k << ' ' << i;
        }
    }
}

TEST(ProgressiveOrder, KeepsTheFirstPointsApartAtThePole) {
    Random random(3, 0);
    std::vector<Point> points;
    while (points.size() < 4'000)
        points.push_back({360 * random.uniform() - 180, 90 - 20 * std::sqrt(random.uniform())});
    const auto order = progressive_order_on_globe(points);
    ASSERT_TRUE(is_permutation(order, points.size()));
    const auto first = first_of(points, order, 250);
    // A cap of 20 degrees has the area 2 pi (1 - cos 20 degrees) on the unit sphere.
    const double hexagonal = std::sqrt(2 / std::sqrt(3.0) * 2 * 3.14159265 * (1 - std::cos(0.349066)) / 250);
    double sum = 0;
    for (const Point p : first) {
        double most = -1;
        for (const Point q : first) {
            if (!(p == q)) most = std::max(most, dot(direction_of(p), direction_of(q)));
        }
        sum += std::acos(most) / hexagonal;
    }
    EXPECT_GT(sum / 250, 0.65);  // the first 250 points in their original order have 0.47
}

struct SurfacePoints {
    std::vector<Point3> positions;
    std::vector<Point3> normals;
    double area = 0;

    std::vector<std::uint32_t> order(bool uniform, Executor& executor = inline_executor(), bool closed = true) const {
        return progressive_order_on_surface(positions, normals, area, uniform, closed, {}, executor);
    }

    SurfacePoints first_of(const std::vector<std::uint32_t>& order, std::size_t k) const {
        SurfacePoints first{{}, {}, area};
        for (std::size_t i = 0; i < k; ++i) {
            first.positions.push_back(positions[order[i]]);
            first.normals.push_back(normals[order[i]]);
        }
        return first;
    }

    /// Returns the distance of each point from its nearest neighbour on the same side, relative to a hexagonal grid of
    /// as many points, in ascending order.
    std::vector<double> distances() const {
        const double hexagonal = hexagonal_spacing(static_cast<double>(positions.size()) / area), reach = 2 * hexagonal;
        const CellList3 cells(positions);
        std::vector<double> distances(positions.size(), reach / hexagonal);
        for (std::size_t i = 0; i < positions.size(); ++i) {
            cells.for_near(positions[i], reach, [&](Point3 position, std::uint32_t number) {
                if (number != i && dot(normals[i], normals[number]) >= 0)
                    distances[i] = std::min(distances[i], length(position - positions[i]) / hexagonal);
            });
        }
        std::ranges::sort(distances);
        return distances;
    }
};

double mean(const std::vector<double>& values) {
    return std::reduce(values.begin(), values.end()) / static_cast<double>(values.size());
}

/// Returns the first points in a progressive order of eight times as many random points on a unit sphere.
SurfacePoints sphere(std::size_t points) {
    constexpr double kPi = std::numbers::pi;
    Random random(11, 0);
    SurfacePoints sphere{{}, {}, 4 * kPi};
    while (sphere.positions.size() < 8 * points) {
        const double z = 1 - 2 * random.uniform(), angle = 2 * kPi * random.uniform(), radius = std::sqrt(1 - z * z);
        sphere.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    sphere.normals = sphere.positions;
    return sphere.first_of(sphere.order(true), points);
}

/// Returns the first points in a progressive order of eight times as many random points on a torus in space, far from
/// the origin.
SurfacePoints ring(std::size_t points) {
    constexpr double kPi = std::numbers::pi, kLarge = 3, kSmall = 1;
    Random random(12, 0);
    SurfacePoints ring{{}, {}, 4 * kPi * kPi * kLarge * kSmall};
    while (ring.positions.size() < 8 * points) {
        const double u = 2 * kPi * random.uniform(), v = 2 * kPi * random.uniform();
        if (random.uniform() * (kLarge + kSmall) > kLarge + kSmall * std::cos(v)) continue;
        const Point3 outwards{std::cos(u), std::sin(u), 0};
        ring.normals.push_back(std::cos(v) * outwards + Point3{0, 0, std::sin(v)});
        ring.positions.push_back(Point3{50, -20, 7} + kLarge * outwards + kSmall * ring.normals.back());
    }
    return ring.first_of(ring.order(true), points);
}

/// Returns the first points in a progressive order of eight times as many random points on a cube.
SurfacePoints cube(std::size_t points) {
    const std::array<Point3, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Random random(13, 0);
    SurfacePoints cube{{}, {}, 24};
    while (cube.positions.size() < 8 * points) {
        const std::size_t face = cube.positions.size() % 6;
        const Point3 normal = (face < 3 ? 1.0 : -1.0) * axes[face % 3];
        const double u = 2 * random.uniform() - 1, v = 2 * random.uniform() - 1;
        cube.positions.push_back(normal + u * axes[(face + 1) % 3] + v * axes[(face + 2) % 3]);
        cube.normals.push_back(normal);
    }
    return cube.first_of(cube.order(true), points);
}

/// Returns points on the two sides of a thin plate, which is inclined.
SurfacePoints plate(const Density& density, std::size_t sites) {
    const Point3 along{0.6, 0, 0.8}, across{0, 1, 0}, up = cross(along, across);
    SurfacePoints plate{{}, {}, 2};
    for (const std::uint64_t seed : {1, 2}) {
        const Point3 normal = seed == 1 ? up : -1 * up;
        for (const Point p : distributed(*Domain::rectangle(1, 1), density, sites, seed)) {
            plate.positions.push_back(p.x * along + p.y * across + 1e-5 * normal);
            plate.normals.push_back(normal);
        }
    }
    return plate;
}

TEST(ProgressiveOrderOnSurface, SpreadsAnyNumberOfFirstPoints) {
    for (const SurfacePoints& points : {sphere(4'096), ring(4'096), cube(4'096)}) {
        const auto order = points.order(true);
        ASSERT_TRUE(is_permutation(order, points.positions.size()));
        for (std::size_t k = 4'096; k >= 64; k /= 2) {
            const std::vector<double> distances = points.first_of(order, k).distances();
            EXPECT_GT(distances.front(), 0.57) << k;
            EXPECT_GT(mean(distances), 0.71) << k;
        }
    }
}

TEST(ProgressiveOrderOnSurface, KeepsTheFirstPointsApartOnSurfacesWithBorders) {
    const SurfacePoints whole = sphere(8'192);
    SurfacePoints half{{}, {}, whole.area / 2};
    for (const Point3 p : whole.positions) {
        if (p.z > 0) half.positions.push_back(p);
    }
    half.normals = half.positions;
    const auto order = half.order(true, inline_executor(), false);
    for (std::size_t k = half.positions.size(); k >= 64; k = k * 3 / 4)
        EXPECT_GT(half.first_of(order, k).distances().front(), 0.579) << k;
}

/// Returns the mean power of points on a unit sphere in all spherical harmonics of degrees 1 to `degrees`, relative to
/// random points.
double low_power(const std::vector<Point3>& points, int degrees) {
    double sum = 0;
    for (const Point3 p : points) {
        for (const Point3 q : points) {
            // By the addition theorem, the harmonics of each degree sum to a Legendre polynomial of the cosine.
            const double cosine = dot(p, q);
            double before = 1, last = cosine;
            sum += 3 * cosine;
            for (int degree = 2; degree <= degrees; ++degree) {
                const double next = ((2 * degree - 1) * cosine * last - (degree - 1) * before) / degree;
                sum += (2 * degree + 1) * next;
                before = last;
                last = next;
            }
        }
    }
    return sum / static_cast<double>(points.size()) / (degrees * (degrees + 2));
}

/// Without the surplus, the mean power is 0.06.
TEST(ProgressiveOrderOnSurface, SuppressesLongWaves) {
    const SurfacePoints points = sphere(4'096);
    const auto order = points.order(true);
    double power = 0;
    for (const std::size_t k : {2'048, 1'024, 512}) {
        const int degrees = static_cast<int>(std::sqrt(static_cast<double>(k)) / 4);
        power += low_power(points.first_of(order, k).positions, degrees) / 3;
    }
    EXPECT_LT(power, 0.038);
}

TEST(ProgressiveOrderOnSurface, SeparatesTheSidesOfThinPlates) {
    const SurfacePoints points = plate(Density::uniform(), 2'048);
    const auto order = points.order(false);
    for (std::size_t k = 4'096; k >= 64; k /= 2) {
        const SurfacePoints first = points.first_of(order, k);
        const std::vector<double> distances = first.distances();
        EXPECT_GT(distances.front(), 0.55) << k;
        EXPECT_GT(mean(distances), 0.71) << k;
        const auto up = static_cast<std::size_t>(std::ranges::count(first.normals, points.normals[0]));
        EXPECT_NEAR(static_cast<double>(up), static_cast<double>(k) / 2, 3 + 0.02 * static_cast<double>(k)) << k;
    }
}

TEST(ProgressiveOrderOnSurface, FollowsTheDensity) {
    constexpr std::array<double, 4> kValues = {1, 6, 2, 3};
    const SurfacePoints points = plate(*Density::grid(2, 2, std::span<const double>(kValues)), 4'096);
    const auto order = points.order(false);
    for (std::size_t k = 64; k <= points.positions.size(); k *= 2) {
        std::array<SurfacePoints, 4> parts;
        const SurfacePoints first = points.first_of(order, k);
        for (std::size_t i = 0; i < k; ++i) {
            SurfacePoints& part = parts[(first.positions[i].y < 0.5 ? 0 : 2) + (first.positions[i].x < 0.3 ? 0 : 1)];
            part.positions.push_back(first.positions[i]);
            part.normals.push_back(first.normals[i]);
        }
        for (std::size_t i = 0; i < 4; ++i) {
            const double wanted = kValues[i] / 12 * static_cast<double>(k);
            const std::size_t count = parts[i].positions.size();
            EXPECT_NEAR(static_cast<double>(count), wanted, 3 + 0.08 * wanted) << k << ' ' << i;
            parts[i].area = 0.5;
            EXPECT_GT(parts[i].distances().front(), 0.43) << k << ' ' << i;
            EXPECT_GT(mean(parts[i].distances()), 0.68) << k << ' ' << i;
        }
    }
}

TEST(ProgressiveOrderOnSurface, IsIdenticalOnAnyNumberOfThreads) {
    const SurfacePoints points = ring(8'192);
    for (const bool even : {true, false}) {
        const auto order = points.order(even);
        for (const std::size_t size : {2, 16}) {
            ThreadExecutor executor(size);
            EXPECT_EQ(points.order(even, executor), order);
        }
    }
}

TEST(ProgressiveOrderOnSurface, AcceptsDegeneratePoints) {
    EXPECT_TRUE(progressive_order_on_surface({}, {}, 1, false, true).empty());
    SurfacePoints points{{{3, 2, 1}}, {{0, 0, 1}}, 1};
    EXPECT_EQ(points.order(false), std::vector<std::uint32_t>{0});
    points.positions.resize(100, points.positions[0]);
    points.normals.resize(100, points.normals[0]);
    EXPECT_TRUE(is_permutation(points.order(false), 100));
    EXPECT_TRUE(is_permutation(points.order(true), 100));
    for (std::size_t i = 0; i < points.positions.size(); ++i) points.positions[i].x += static_cast<double>(i);
    EXPECT_TRUE(is_permutation(points.order(false), 100));
}

/// Returns the least and the mean distance of points from their nearest neighbours, relative to the
/// densest packing of as many points in `volume`.
/// @param torus  sides of a torus; 0 for any other domain
std::pair<double, double> distances_in_space(const std::vector<Point3>& points, double volume, double torus) {
    const double densest = kCubicSpacing * std::cbrt(volume / static_cast<double>(points.size()));
    double least = 2, sum = 0;
    for (const Point3 p : points) {
        double nearest = 2 * densest;
        for (const Point3 q : points) {
            Point3 away = p - q;
            if (torus > 0)
                away = away - torus * Point3{std::round(away.x / torus), std::round(away.y / torus),
                                             std::round(away.z / torus)};
            if (!(p == q)) nearest = std::min(nearest, length(away));
        }
        least = std::min(least, nearest / densest);
        sum += nearest / densest;
    }
    return {least, sum / static_cast<double>(points.size())};
}

std::vector<Point3> first_of(const std::vector<Point3>& points, const std::vector<std::uint32_t>& order,
                             std::size_t k) {
    std::vector<Point3> first;
    for (std::size_t i = 0; i < k; ++i) first.push_back(points[order[i]]);
    return first;
}

/// Random points have a mean distance of 0.49.
TEST(ProgressiveOrderInSpace, SpreadsAnyNumberOfFirstPointsOfATorus) {
    const BoxDomain3 torus{{3, 3, 3}, true};
    const auto points = distribute_in_volume(torus, VoxelDensity::uniform(), {.sites = 2'048})->points;
    const auto order = progressive_order_in_space({{}, torus.sides}, true, points, 1, true);
    ASSERT_TRUE(is_permutation(order, points.size()));
    for (std::size_t k = 2'048; k >= 64; k -= k / 3) {
        const auto [least, mean] = distances_in_space(first_of(points, order, k), torus.volume(), 3);
        EXPECT_GT(least, 0.5799) << k;
        EXPECT_GT(mean, 0.7) << k;
    }
}

TEST(ProgressiveOrderInSpace, FollowsTheDensityOfABox) {
    constexpr std::array<double, 2> kValues = {1, 5};
    const BoxDomain3 box{{2, 1, 1}, false};
    const VoxelDensity density = *VoxelDensity::create({2, 1, 1}, kValues);
    const auto points = distribute_in_volume(box, density, {.sites = 3'000, .quality = Quality::Draft})->points;
    std::vector<Point3> moved = points;
    for (Point3& p : moved) p = 1e-300 * p - Point3{4e-300, 0, 0};
    const Box3 bounds{{-4e-300, 0, 0}, {-2e-300, 1e-300, 1e-300}};
    const auto order = progressive_order_in_space(bounds, false, moved, 1, false);
    for (std::size_t k = 48; k <= 3'000; k += k / 2) {
        std::array<std::vector<Point3>, 2> halves;
        for (const Point3 p : first_of(points, order, k)) halves[p.x < 1 ? 0 : 1].push_back(p);
        const auto all = static_cast<double>(k);
        EXPECT_NEAR(static_cast<double>(halves[1].size()), all * 5 / 6, 2 + 0.03 * all) << k;
        for (const auto& half : halves) EXPECT_GT(distances_in_space(half, 1, 0).second, 0.7) << k;
    }
    ThreadExecutor executor(2);
    EXPECT_EQ(progressive_order_in_space(bounds, false, moved, 1, false, {}, executor), order);
}

TEST(ProgressiveOrder, AcceptsDegeneratePoints) {
    const Domain square = *Domain::rectangle(2, 1);
    EXPECT_TRUE(progressive_order(square, {}, false).empty());
    EXPECT_TRUE(progressive_order_on_globe({}).empty());
    const std::vector<Point> one = {{1, 0.5}}, equal(100, Point{0.5, 0.5});
    EXPECT_EQ(progressive_order(square, one, false), std::vector<std::uint32_t>{0});
    EXPECT_TRUE(is_permutation(progressive_order(square, equal, false), 100));
    EXPECT_TRUE(is_permutation(progressive_order_on_globe(equal), 100));
    const std::vector<Point> opposite = {{0, 0}, {180, 0}, {0, 90}, {0, -90}, {90, 0}, {-90, 0}};
    EXPECT_TRUE(is_permutation(progressive_order_on_globe(opposite), opposite.size()));
    const std::vector<Point3> same(100, Point3{1, 1, 0});
    for (const bool is_torus : {false, true})
        EXPECT_TRUE(is_permutation(progressive_order_in_space({{}, {2, 2, 1e-6}}, is_torus, same, 1, is_torus), 100));
}

TEST(ProgressiveOrder, IsDeterministic) {
    const Domain square = *Domain::rectangle(1, 1);
    const auto points = distributed(square, Density::uniform(), 1'000, 1);
    EXPECT_EQ(progressive_order(square, points, false), progressive_order(square, points, false));
}

TEST(ProgressiveOrder, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const Domain square = *Domain::rectangle(1, 1);
    const auto points = distributed(square, Density::uniform(), 3'000, 1);
    EXPECT_TRUE(is_permutation(progressive_order(square, points, false, source.get_token()), points.size()));
}

TEST(Reorder, ReordersTheMesh) {
    Options options;
    options.sites = 50;
    options.keep_mesh = true;
    const Domain square = *Domain::rectangle(1, 1);
    const Distribution given = *distribute(square, Density::uniform(), options);
    Distribution ordered = given;
    const auto order = progressive_order(square, given.points, false);
    reorder(ordered, order);
    for (std::size_t i = 0; i < order.size(); ++i) {
        EXPECT_EQ(ordered.points[i], given.points[order[i]]);
        EXPECT_EQ(ordered.mesh->vertices[i], ordered.points[i]);
    }
    for (std::size_t t = 0; t < given.mesh->triangles.size(); ++t) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            EXPECT_EQ(ordered.mesh->vertices[ordered.mesh->triangles[t][corner]],
                      given.mesh->vertices[given.mesh->triangles[t][corner]]);
        }
    }
    EXPECT_EQ(ordered.mesh->boundary, given.mesh->boundary);  // these vertices follow the points
}

/// A quadratic time would be minutes.
TEST(ProgressiveOrder, ListsFurtherCopiesOfCoincidentPointsLast) {
    std::vector<Point> points(100'000, Point{0.5, 0.5});
    points[7] = {0.1, 0.1};
    points[8] = points[9] = {0.9, 0.1};
    const auto order = progressive_order(*Domain::rectangle(1, 1), points, false);
    const std::set<std::uint32_t> all(order.begin(), order.end());
    EXPECT_EQ(all.size(), points.size());
    EXPECT_EQ(std::set<std::uint32_t>(order.begin(), order.begin() + 3), (std::set<std::uint32_t>{0, 7, 8}));
    EXPECT_EQ(std::set<std::uint32_t>(order.begin() + 3, order.begin() + 5), (std::set<std::uint32_t>{1, 9}));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/order/progressive_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "core/analysis/analysis.h"
#include "core/ccdt/ccdt.h"
#include "core/globe/chart.h"
#include "core/order/reorder.h"
#include "core/parallel/thread_executor.h"
#include "core/random.h"
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
            EXPECT_GT(first.min_distance, 0.57) << seed << ' ' << k;
            EXPECT_GT(first.mean_distance, 0.71) << seed << ' ' << k;
            EXPECT_LT(*first.low_frequency_power, 0.13) << seed << ' ' << k;
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
        const auto order = progressive_order(square, points, false);
        for (std::size_t k = 128; k < points.size(); k += k / 3)
            EXPECT_LT(test::noise(square, first_of(points, order, k), 2), -11.5) << seed << ' ' << k;
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

}  // namespace
}  // namespace ccdt

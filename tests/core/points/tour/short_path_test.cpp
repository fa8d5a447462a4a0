// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/tour/short_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "core/base/random.h"

namespace ccdt {
namespace {

std::vector<Point> random_points(std::size_t count) {
    Random random(7, 0);
    std::vector<Point> points(count);
    for (Point& p : points) p = {random.uniform(), random.uniform()};
    return points;
}

/// Returns the points of a grid of unit spacing, in an irregular order.
std::vector<Point> grid(std::size_t side) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < side * side; ++i) {
        const std::size_t mixed = i * 7'919 % (side * side);
        points.push_back({static_cast<double>(mixed % side), static_cast<double>(mixed / side)});
    }
    return points;
}

std::vector<Point> in_order(const std::vector<Point>& points, const std::vector<std::uint32_t>& order) {
    std::vector<Point> result;
    for (const std::uint32_t i : order) result.push_back(points[i]);
    return result;
}

double shortened(const std::vector<Point>& points) {
    return path_length(in_order(points, short_path(points)));
}

/// Returns the length of the shortest path, by trying all orders.
double shortest(const std::vector<Point>& points) {
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    double best = path_length(points);
    do {
        best = std::min(best, path_length(in_order(points, order)));
    } while (std::next_permutation(order.begin(), order.end()));
    return best;
}

bool is_permutation_of(std::vector<std::uint32_t> order, std::size_t count) {
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (order[i] != i) return false;
    }
    return order.size() == count;
}

TEST(ShortPath, VisitsEachPointOnce) {
    for (const std::size_t count : {0U, 1U, 2U, 3U, 4U, 5U, 10U, 1000U}) {
        EXPECT_TRUE(is_permutation_of(short_path(random_points(count)), count)) << count;
    }
}

TEST(ShortPath, AcceptsCoincidentPoints) {
    std::vector<Point> points = random_points(50);
    points.insert(points.end(), points.begin(), points.begin() + 25);
    EXPECT_TRUE(is_permutation_of(short_path(points), 75));
    const std::vector<Point> same(20, Point{3, 4});
    EXPECT_TRUE(is_permutation_of(short_path(same), 20));
}

TEST(ShortPath, FollowsALine) {
    std::vector<Point> points;
    for (int i = 0; i < 100; ++i) points.push_back({(i * 37) % 100 * 3.0, (i * 37) % 100 * 4.0});
    EXPECT_NEAR(shortened(points), 99 * 5, 1e-9);
}

TEST(ShortPath, IsCloseToTheShortestPath) {
    for (std::size_t count = 2; count <= 8; ++count) {
        const std::vector<Point> points = random_points(count);
        EXPECT_LT(shortened(points), 1.1 * shortest(points)) << count;
    }
    // A boustrophedon is the shortest path through a grid.
    EXPECT_LT(shortened(grid(60)), 1.05 * (60 * 60 - 1));
}

/// The shortest path through many random points of a unit square has length 0.7124 sqrt(n) (Johnson, McGeoch 1996).
TEST(ShortPath, ReachesTheDocumentedLength) {
    const std::vector<Point> points = random_points(20'000);
    EXPECT_LT(shortened(points), 1.1 * 0.7124 * std::sqrt(20'000));
    EXPECT_GT(shortened(points), 0.7124 * std::sqrt(20'000));
}

TEST(ShortPath, HandlesCrowdedPoints) {
    std::vector<Point> points = random_points(4'000);
    for (std::size_t i = 0; i < 2'000; ++i) points[i] = Point{0.5, 0.5} + 1e-5 * points[i];
    const auto order = short_path(points);
    EXPECT_TRUE(is_permutation_of(order, points.size()));
    EXPECT_LT(path_length(in_order(points, order)), 1.15 * 0.7124 * std::sqrt(2'000));
}

TEST(ShortTour, VisitsEachPointOnce) {
    for (const std::size_t count : {0U, 1U, 2U, 3U, 4U, 5U, 10U, 1000U}) {
        EXPECT_TRUE(is_permutation_of(short_tour(random_points(count)), count)) << count;
    }
    EXPECT_TRUE(is_permutation_of(short_tour(std::vector<Point>(20, Point{3, 4})), 20));
}

/// The shortest tour through many random points of a unit square has the length of the shortest path.
TEST(ShortTour, IsHardlyLongerThanAPath) {
    const std::vector<Point> points = random_points(20'000);
    std::vector<Point> tour = in_order(points, short_tour(points));
    tour.push_back(tour.front());
    EXPECT_NEAR(path_length(tour) / shortened(points), 1, 0.01);
}

TEST(ShortPath, IsInvariantUnderTranslationAndScaling) {
    const std::vector<Point> points = random_points(2'000);
    std::vector<Point> others;
    for (const Point& p : points) others.push_back(1024 * p);
    EXPECT_EQ(short_path(points), short_path(others));
}

TEST(ShortPath, IsAPermutationAfterAStop) {
    std::stop_source source;
    source.request_stop();
    const std::vector<Point> points = random_points(10'000);
    const auto order = short_path(points, source.get_token());
    EXPECT_TRUE(is_permutation_of(order, points.size()));
    EXPECT_GT(path_length(in_order(points, order)), shortened(points));
    EXPECT_LT(path_length(in_order(points, order)), 1.1 * std::sqrt(10'000));
}

}  // namespace
}  // namespace ccdt

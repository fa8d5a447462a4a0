// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/apportion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {
namespace {

using Counts = std::vector<std::size_t>;
using Quotas = std::vector<double>;

Counts apportion(const std::vector<Point3>& positions, const Quotas& quotas) {
    return apportion(positions, std::vector<Quotas>{quotas}).front();
}

/// Returns the centres of squares in rows from the south.
std::vector<Point3> grid(int columns, int rows) {
    std::vector<Point3> positions;
    for (int i = 0; i < columns * rows; ++i) positions.push_back({i % columns + 0.5, i / columns + 0.5, 0});
    return positions;
}

std::vector<Point3> random_positions(std::size_t count, std::uint64_t seed) {
    Random random(seed, 0);
    std::vector<Point3> positions(count);
    for (Point3& p : positions) p = {random.uniform(), random.uniform(), 0};
    return positions;
}

/// Returns log-normal quotas: the largest of a thousand is some thousands of times the smallest.
Quotas populations(std::size_t count, double median, std::uint64_t seed) {
    Random random(seed, 1);
    Quotas quotas(count);
    for (double& quota : quotas) {
        const double radius = std::sqrt(-2 * std::log(random.uniform()));
        quota = median * std::exp(1.45 * radius * std::cos(2 * std::numbers::pi * random.uniform()));
    }
    return quotas;
}

std::size_t sum_of(const Counts& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

/// Returns the error of the sum over the places of which `is_inside` is true.
double error_in(const std::vector<Point3>& positions, const Quotas& quotas, const Counts& counts,
                const std::function<bool(Point3)>& is_inside) {
    double error = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (is_inside(positions[i])) error += static_cast<double>(counts[i]) - quotas[i];
    }
    return error;
}

/// Returns the root mean square of the errors in random rectangles in the unit square.
double error_in_rectangles(const std::vector<Point3>& positions, const Quotas& quotas, const Counts& counts) {
    constexpr int kRectangles = 500;
    Random random(7, 0);
    double sum = 0;
    for (int i = 0; i < kRectangles; ++i) {
        const auto [west, east] = std::minmax({random.uniform(), random.uniform()});
        const auto [south, north] = std::minmax({random.uniform(), random.uniform()});
        sum += std::pow(error_in(positions, quotas, counts,
                                 [&, w = west, e = east, s = south, n = north](Point3 p) {
                                     return p.x >= w && p.x < e && p.y >= s && p.y < n;
                                 }),
                        2);
    }
    return std::sqrt(sum / kRectangles);
}

/// Expects that each number is its quota rounded up or down, and that the numbers add up to the rounded sum.
void expect_rounded(const Quotas& quotas, const Counts& counts) {
    for (std::size_t i = 0; i < quotas.size(); ++i)
        ASSERT_LT(std::abs(static_cast<double>(counts[i]) - quotas[i]), 1) << "place " << i;
    EXPECT_LE(std::abs(static_cast<double>(sum_of(counts)) - std::accumulate(quotas.begin(), quotas.end(), 0.0)),
              0.5 + 1e-6);
}

TEST(Apportion, GivesEachQuarterOfAGridItsSum) {
    const auto positions = grid(20, 20);
    const Counts counts = apportion(positions, Quotas(400, 0.4));
    for (int quarter = 0; quarter < 4; ++quarter) {
        const auto begin = counts.begin() + 100 * quarter;
        EXPECT_EQ(std::accumulate(begin, begin + 100, std::size_t{0}), 40U) << quarter;
    }
}

TEST(Apportion, GivesBothSidesOfABorderTheirSums) {
    const auto positions = grid(20, 20);
    Quotas quotas;
    for (const Point3& p : positions) quotas.push_back(p.x < 10 ? 0.1 : 0.4);
    const Counts counts = apportion(positions, quotas);
    expect_rounded(quotas, counts);
    EXPECT_NEAR(error_in(positions, quotas, counts, [](Point3 p) { return p.x < 10; }), 0, 1e-9);
}

TEST(Apportion, KeepsTheSumOfEveryHalf) {
    const auto positions = random_positions(1024, 1);
    for (const double median : {0.001, 0.02, 0.3, 20.0}) {
        const Quotas quotas = populations(positions.size(), median, 2);
        const Counts counts = apportion(positions, quotas);
        expect_rounded(quotas, counts);
        // Repeats the halving of the tree across the longer sides.
        const std::function<void(std::vector<std::size_t>)> check = [&](std::vector<std::size_t> own) {
            double error = 0;
            Point3 least = positions[own.front()], most = least;
            for (const std::size_t i : own) {
                error += static_cast<double>(counts[i]) - quotas[i];
                least = {std::min(least.x, positions[i].x), std::min(least.y, positions[i].y), 0};
                most = {std::max(most.x, positions[i].x), std::max(most.y, positions[i].y), 0};
            }
            ASSERT_LT(std::abs(error), 1) << own.size() << " places";
            if (own.size() == 1) return;
            const bool is_wide = most.x - least.x >= most.y - least.y;
            std::ranges::sort(own, {}, [&](std::size_t i) { return is_wide ? positions[i].x : positions[i].y; });
            const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
            check({own.begin(), middle});
            check({middle, own.end()});
        };
        std::vector<std::size_t> all(positions.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        check(all);
    }
}

TEST(Apportion, HasSmallErrorsInRectangles) {
    // Numbers rounded independently have errors of about 4 to 5 in these rectangles.
    const auto positions = random_positions(2500, 3);
    for (const double median : {0.05, 0.3, 15.0}) {
        const Quotas quotas = populations(positions.size(), median, 4);
        EXPECT_LT(error_in_rectangles(positions, quotas, apportion(positions, quotas)), 2.2) << median;
    }
    const Quotas equal(positions.size(), 0.2);
    EXPECT_LT(error_in_rectangles(positions, equal, apportion(positions, equal)), 2.2);
}

TEST(Apportion, SpreadsFewUnitsEvenly) {
    struct Case {
        int side;
        double quota;
    };
    for (const auto [side, quota] : {Case{60, 0.1}, Case{100, 0.013}, Case{200, 0.0025}, Case{64, 0.25}}) {
        const auto positions = grid(side, side);
        const Counts counts = apportion(positions, Quotas(positions.size(), quota));
        std::vector<Point3> chosen;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            if (counts[i] > 0) chosen.push_back(positions[i]);
        }
        double sum = 0, least = side;
        for (const Point3& p : chosen) {
            double nearest = side;
            for (const Point3& q : chosen) {
                if (p != q) nearest = std::min(nearest, length(p - q));
            }
            sum += nearest;
            least = std::min(least, nearest);
        }
        const double spacing = hexagonal_spacing(quota);
        EXPECT_GT(sum / static_cast<double>(chosen.size()), 0.72 * spacing) << quota;  // 0.47 if chosen at random
        EXPECT_GT(least, 0.4 * spacing) << quota;
    }
}

TEST(Apportion, KeepsTheSumsOfEachClassAndOfAllClasses) {
    const auto positions = random_positions(2048, 5);
    std::vector<Quotas> quotas;
    Quotas all(positions.size());
    for (const double median : {0.3, 0.1, 0.02})
        quotas.push_back(populations(positions.size(), median, quotas.size() + 6));
    const auto counts = apportion(positions, quotas);
    Counts sums(positions.size());
    for (std::size_t number = 0; number < quotas.size(); ++number) {
        expect_rounded(quotas[number], counts[number]);
        EXPECT_LT(error_in_rectangles(positions, quotas[number], counts[number]), 2.2) << number;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            all[i] += quotas[number][i];
            sums[i] += counts[number][i];
        }
    }
    EXPECT_LT(error_in_rectangles(positions, all, sums), 2.4);
}

TEST(Apportion, DependsOnPositionsNotOnTheirOrder) {
    const auto positions = random_positions(700, 8);
    const Quotas quotas = populations(positions.size(), 0.2, 9);
    const Counts counts = apportion(positions, quotas);
    std::vector<std::size_t> order(positions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    Random random(10, 0);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.bits() % i]);
    std::vector<Point3> shuffled;
    Quotas own;
    Counts expected;
    for (const std::size_t i : order) {
        shuffled.push_back(positions[i]);
        own.push_back(quotas[i]);
        expected.push_back(counts[i]);
    }
    EXPECT_EQ(apportion(shuffled, own), expected);
}

TEST(Apportion, RoundsPlacesOnASphere) {
    std::vector<Point3> positions;
    for (int i = 0; i < 3000; ++i) {  // a spiral with equal areas
        const double z = 1 - (i + 0.5) / 1500, angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        positions.push_back({std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z});
    }
    const Quotas quotas(positions.size(), 0.13);
    const Counts counts = apportion(positions, quotas);
    expect_rounded(quotas, counts);
    Random random(11, 0);
    for (int i = 0; i < 200; ++i) {
        const Point3 pole = positions[random.bits() % positions.size()];
        const double height = 2 * random.uniform() - 1;
        EXPECT_LT(std::abs(error_in(positions, quotas, counts, [&](Point3 p) { return dot(p, pole) > height; })), 6);
    }
}

TEST(Apportion, HandlesTheEndsOfRanges) {
    EXPECT_TRUE(apportion({}, Quotas()).empty());
    EXPECT_EQ(apportion({{1, 2, 3}}, {0.4}), Counts{0});
    EXPECT_EQ(apportion({{1, 2, 3}}, {0.5}), Counts{1});
    EXPECT_EQ(apportion({{1, 2, 3}, {1, 2, 4}}, {0, 0}), (Counts{0, 0}));
    EXPECT_EQ(apportion({{1, 2, 3}, {1, 2, 4}}, {3, 4}), (Counts{3, 4}));
    // Sums of these quotas have rounding errors.
    EXPECT_EQ(sum_of(apportion(random_positions(30, 1), Quotas(30, 0.1))), 3U);
    EXPECT_EQ(apportion(random_positions(10, 1), {1, 0.1, 0.1, 1, 0.1, 2, 5, 0.1, 0.1, 7})[6], 5U);

    const Counts same = apportion(std::vector<Point3>(1000, {5, 5, 0}), Quotas(1000, 0.3));
    EXPECT_EQ(sum_of(same), 300U);

    constexpr double kHuge = std::numeric_limits<double>::max(), kTiny = std::numeric_limits<double>::denorm_min();
    const std::vector<Point3> far = {{-kHuge, 0, 0}, {kHuge, kHuge, 0}, {0, -kHuge, 0}, {kTiny, 0, 0}};
    EXPECT_EQ(sum_of(apportion(far, Quotas(4, 0.5))), 2U);
    EXPECT_EQ(sum_of(apportion(far, Quotas(4, kTiny))), 0U);
    EXPECT_EQ(apportion(far, {kTiny, 1e-308, 0.75, kTiny}), (Counts{0, 0, 1, 0}));
    EXPECT_EQ(apportion(far, {1e15, 0, 0.75, 3}), (Counts{1'000'000'000'000'000, 0, 1, 3}));
}

TEST(Apportion, BoundsTheWorkForPlacesOfAllScales) {
    // Places whose distances from the origin grow exponentially, beside a dense cluster.
    std::vector<Point3> positions = random_positions(5'000, 12);
    Random random(13, 0);
    for (int i = 0; i < 5'000; ++i) {
        const double distance = std::pow(10, 200 * random.uniform()), angle = 7 * random.uniform();
        positions.push_back({distance * std::cos(angle), distance * std::sin(angle), 0});
    }
    const Quotas quotas(positions.size(), 0.4);
    expect_rounded(quotas, apportion(positions, quotas));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/nonuniform_transform.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Complex = std::complex<double>;

constexpr double kError = 1e-10;        // relative to the sum of |weights|
constexpr double kErrorOfNoise = 1e-9;  // relative to the square root of that sum

std::vector<WeightedPoint> noise(std::size_t count) {
    Random random(7, 0);
    std::vector<WeightedPoint> points(count);
    for (auto& point : points) point = {{random.uniform(), random.uniform()}, 1};
    return points;
}

/// Assigns weights of both signs.
/// @returns  the sum of |weights|
double weigh(std::vector<WeightedPoint>& points, std::uint64_t seed) {
    double sum = 0;
    Random random(seed, 0);
    for (auto& point : points) {
        point.weight = 2 * random.uniform() - 1;
        sum += std::abs(point.weight);
    }
    return sum;
}

/// Computes the sum directly, point by point.
Complex direct_sum(const std::vector<WeightedPoint>& points, int i, int j) {
    Complex sum;
    for (const auto& [position, weight] : points) {
        sum += weight * std::polar(1.0, -2 * std::numbers::pi * (i * position.x + j * position.y));
    }
    return sum;
}

/// Returns the largest difference from the direct sums over all frequencies.
double largest_error(const std::vector<WeightedPoint>& points, int highest_x, int highest_y) {
    NonuniformTransform transform(highest_x, highest_y);
    transform.run(points, {});
    double largest = 0;
    for (int i = 0; i <= highest_x; ++i) {
        for (int j = -highest_y; j <= highest_y; ++j) {
            largest = std::max(largest, std::abs(transform.value(i, j) - direct_sum(points, i, j)));
        }
    }
    return largest;
}

TEST(NonuniformTransform, EqualsTheSumOverRandomPoints) {
    const auto points = noise(400);
    EXPECT_LT(largest_error(points, 40, 40), kErrorOfNoise * std::sqrt(400));
}

TEST(NonuniformTransform, EqualsTheSumForAnyWeights) {
    auto points = noise(300);
    const double sum = weigh(points, 8);
    EXPECT_LT(largest_error(points, 30, 30), kError * sum);
}

TEST(NonuniformTransform, EqualsTheSumOnGridsOfAnyShape) {
    const auto points = noise(100);
    EXPECT_LT(largest_error(points, 0, 0), kError * 100);
    EXPECT_LT(largest_error(points, 200, 0), kError * 100);
    EXPECT_LT(largest_error(points, 1, 150), kError * 100);
    EXPECT_LT(largest_error(points, 31, 47), kError * 100);
}

TEST(NonuniformTransform, EqualsTheSumAtTheBorder) {
    std::vector<WeightedPoint> points;
    for (const double x : {0.0, 0x1p-60, 0.5, 1 - 0x1p-53, 1.0}) {
        for (const double y : {0.0, 0.25, 1.0}) points.push_back({{x, y}, 1});
    }
    EXPECT_LT(largest_error(points, 25, 25), kError * static_cast<double>(points.size()));
}

TEST(NonuniformTransform, EqualsTheSumOverALattice) {
    // All terms are in phase at some frequencies, including one beyond the highest: the worst case of aliasing.
    std::vector<WeightedPoint> points;
    for (int r = 0; r < 16; ++r) {
        for (int c = 0; c < 16; ++c) points.push_back({{c / 16.0, r / 16.0}, 1});
    }
    EXPECT_LT(largest_error(points, 40, 40), kError * 256);
}

TEST(NonuniformTransform, IsIndependentOfThePreviousRun) {
    const auto points = noise(50);
    NonuniformTransform fresh(10, 10), used(10, 10);
    used.run(noise(80), {});
    used.run(points, {});
    fresh.run(points, {});
    for (int i = 0; i <= 10; ++i) {
        for (int j = -10; j <= 10; ++j) EXPECT_EQ(used.value(i, j), fresh.value(i, j));
    }
}

TEST(ShiftedTransform, EqualsTheSumAroundAnyFrequency) {
    auto points = noise(300);
    const double sum = weigh(points, 9);
    ShiftedTransform transform(20, 11, 0);
    for (const auto& [x, y] : {std::pair(0, 0), std::pair(7, -30), std::pair(5'000, 4'000)}) {
        transform.run(points, {x, y, 0}, {});
        for (int i = -20; i <= 20; ++i) {
            for (int j = -11; j <= 11; ++j)
                ASSERT_LT(std::abs(transform.value(i, j, 0) - direct_sum(points, x + i, y + j)), kError * sum);
        }
    }
}

TEST(NonuniformTransform, EqualsTheSumInSpace) {
    Random random(7, 1);
    std::vector<BasicWeightedPoint<Point3>> points(100);
    for (auto& point : points) point = {{random.uniform(), random.uniform(), random.uniform()}, random.uniform()};
    const auto sum = [&](int i, int j, int k) {
        Complex total;
        for (const auto& [p, weight] : points)
            total += weight * std::polar(1.0, -2 * std::numbers::pi * (i * p.x + j * p.y + k * p.z));
        return total;
    };
    for (const int highest_z : {0, 1, 7}) {
        NonuniformTransform whole(5, 8, highest_z);
        ShiftedTransform part(5, 8, highest_z);
        whole.run(points, {});
        part.run(points, {3, -20, 11}, {});
        for (int k = -highest_z; k <= highest_z; ++k) {
            for (int j = -8; j <= 8; ++j) {
                for (int i = -5; i <= 5; ++i) {
                    ASSERT_LT(std::abs(whole.value(std::abs(i), j, k) - sum(std::abs(i), j, k)), kError * 100);
                    ASSERT_LT(std::abs(part.value(i, j, k) - sum(3 + i, j - 20, 11 + k)), kError * 100);
                }
            }
        }
    }
}

TEST(NonuniformTransform, PredictsItsSize) {
    EXPECT_EQ(NonuniformTransform::cells(100, 50), 400 * 200);
    EXPECT_EQ(NonuniformTransform::cells(0, 0), 24 * 24);
    EXPECT_GT(NonuniformTransform::cells(1e200, 1), 1e200);
}

}  // namespace
}  // namespace ccdt

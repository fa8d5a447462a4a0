// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/density.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

Result<Density> grid(int width, int height, const std::vector<double>& values) {
    return Density::grid(width, height, std::span<const double>(values));
}

TEST(Density, IsUniformWithoutAGrid) {
    EXPECT_TRUE(Density::uniform().is_uniform());
    EXPECT_FALSE(grid(1, 1, {1})->is_uniform());
}

TEST(Density, KeepsTheRatiosOfItsValues) {
    const auto density = grid(3, 2, {1, 2, 3, 4, 0, 6});
    ASSERT_TRUE(density);
    EXPECT_EQ(density->width(), 3);
    EXPECT_EQ(density->height(), 2);
    EXPECT_EQ(density->largest(), 1.5);
    EXPECT_EQ(density->value(2, 0), 0.75);
    EXPECT_EQ(density->value(1, 1), 0);
    EXPECT_EQ(density->total(), 4);
    const auto sums = density->row_sums(1);
    EXPECT_EQ(std::vector<double>(sums.begin(), sums.end()), (std::vector<double>{0, 1, 1, 2.5}));
}

TEST(Density, IsInvariantUnderPowersOfTwo) {
    const std::vector<double> values{0, 1, 1.0 / 3, 5, 0.7, 1e-9};
    const Density expected = *grid(3, 2, values);
    for (const int exponent : {-1000, -40, -1, 1, 40, 1000}) {
        std::vector<double> scaled;
        for (const double value : values) scaled.push_back(std::ldexp(value, exponent));
        const Density density = *grid(3, 2, scaled);
        EXPECT_EQ(density.total(), expected.total()) << exponent;
        for (int row = 0; row < 2; ++row)
            EXPECT_TRUE(std::ranges::equal(density.row_sums(row), expected.row_sums(row))) << exponent;
    }
}

TEST(Density, ScalesTheLargestValueNearOne) {
    constexpr double kMinDouble = 5e-324, kMaxDouble = std::numeric_limits<double>::max();
    for (const double value : {kMinDouble, 3e-310, 1e-300, 0.3, 1.0, 1.9999, 2.0, 1e100, kMaxDouble}) {
        const auto density = grid(2, 1, {0, value});
        ASSERT_TRUE(density) << value;
        EXPECT_GE(density->largest(), 1) << value;
        EXPECT_LT(density->largest(), 2) << value;
        EXPECT_EQ(density->value(1, 0), density->largest()) << value;
        EXPECT_EQ(density->value(0, 0), 0) << value;
    }
}

TEST(Density, TreatsNegligibleValuesAsZero) {
    EXPECT_EQ(grid(2, 1, {Density::kMin, 1})->value(0, 0), Density::kMin);
    EXPECT_EQ(grid(2, 1, {Density::kMin / 2, 1})->value(0, 0), 0);
    EXPECT_EQ(grid(2, 1, {5e-324, 1})->value(0, 0), 0);
    EXPECT_EQ(grid(2, 1, {5e-324, 1})->support().left, 1);
    EXPECT_EQ(grid(2, 1, {1e-320, 1e300})->value(0, 0), 0);
}

TEST(Density, AcceptsFloats) {
    const std::vector<float> values{0.5f, 0.25f};
    const auto density = Density::grid(2, 1, std::span<const float>(values));
    ASSERT_TRUE(density);
    EXPECT_EQ(density->value(1, 0), 0.5);
}

TEST(Density, FindsItsSupport) {
    const auto support = [](std::vector<double> values) { return Density::grid(4, 3, std::span(values))->support(); };
    const auto expect = [](const CellBlock& block, int left, int low, int right, int high) {
        EXPECT_EQ(block.left, left);
        EXPECT_EQ(block.low, low);
        EXPECT_EQ(block.right, right);
        EXPECT_EQ(block.high, high);
    };
    expect(support({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}), 0, 0, 4, 3);
    expect(support({0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0}), 2, 1, 3, 2);
    expect(support({0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}), 1, 1, 3, 3);
    expect(support({0, 0, 0, 1e-30, 0, 0, 0, 0, 1e30, 0, 0, 0}), 0, 0, 4, 3);
}

TEST(Density, ResamplesABlock) {
    const std::vector<double> values{9, 9, 9, 9, 9, 1, 2, 9, 9, 3, 4, 9};
    const Density density = *Density::grid(4, 3, std::span(values));
    const double unit = density.largest() / 9;
    const auto expect = [&](const std::vector<double>& masses, std::initializer_list<double> expected) {
        ASSERT_EQ(masses.size(), expected.size());
        for (std::size_t i = 0; i < masses.size(); ++i) EXPECT_EQ(masses[i], unit * expected.begin()[i]) << i;
    };
    std::vector<double> masses(4);
    density.resample_row({1, 1, 3, 3}, 4, 4, 0, masses);
    expect(masses, {0.25, 0.25, 0.5, 0.5});
    density.resample_row({1, 1, 3, 3}, 4, 1, 0, masses);
    expect(masses, {2, 2, 3, 3});
    density.resample_row(density.cells(), 4, 3, 2, masses);
    expect(masses, {9, 3, 4, 9});
}

TEST(Density, RefusesWrongCounts) {
    for (const auto& density : {grid(2, 2, {1, 2, 3}), grid(2, 1, {1, 2, 3})}) {
        ASSERT_FALSE(density);
        EXPECT_EQ(density.error().code, ErrorCode::Malformed);
        EXPECT_EQ(density.error().field, "values");
    }
    EXPECT_EQ(grid(0, 5, {}).error().code, ErrorCode::Malformed);
    EXPECT_EQ(grid(-1, -1, {1}).error().code, ErrorCode::Malformed);
}

TEST(Density, RefusesValuesOutOfRangeAndNamesThem) {
    for (const double bad : {-1.0, -1e-300, -5e-324, std::numeric_limits<double>::infinity(), std::nan("")}) {
        const auto density = grid(2, 2, {1, 1, bad, 1});
        ASSERT_FALSE(density) << bad;
        EXPECT_EQ(density.error().code, ErrorCode::Malformed);
        EXPECT_EQ(density.error().field, "values/2");
    }
}

TEST(Density, RefusesZeroEverywhere) {
    const auto density = grid(2, 1, {0, 0});
    ASSERT_FALSE(density);
    EXPECT_EQ(density.error().code, ErrorCode::Unusable);
}

}  // namespace
}  // namespace ccdt

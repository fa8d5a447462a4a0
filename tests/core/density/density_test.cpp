#include "core/density/density.h"

#include <cmath>
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

TEST(Density, KeepsItsValues) {
    const auto density = grid(3, 2, {1, 2, 3, 4, 0, 6});
    ASSERT_TRUE(density);
    EXPECT_EQ(density->width(), 3);
    EXPECT_EQ(density->height(), 2);
    EXPECT_EQ(density->value(2, 0), 3);
    EXPECT_EQ(density->value(1, 1), 0);
    EXPECT_EQ(density->total(), 16);
    const auto sums = density->row_sums(1);
    EXPECT_EQ(std::vector<double>(sums.begin(), sums.end()), (std::vector<double>{0, 4, 4, 10}));
}

TEST(Density, TakesFloats) {
    const std::vector<float> values{0.5f, 0.25f};
    const auto density = Density::grid(2, 1, std::span<const float>(values));
    ASSERT_TRUE(density);
    EXPECT_EQ(density->value(1, 0), 0.25);
}

TEST(Density, KnowsItsSupport) {
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
    std::vector<double> masses(4);
    density.resample_row({1, 1, 3, 3}, 4, 4, 0, masses);
    EXPECT_EQ(masses, (std::vector<double>{0.25, 0.25, 0.5, 0.5}));
    density.resample_row({1, 1, 3, 3}, 4, 1, 0, masses);
    EXPECT_EQ(masses, (std::vector<double>{2, 2, 3, 3}));
    density.resample_row(density.cells(), 4, 3, 2, masses);
    EXPECT_EQ(masses, (std::vector<double>{9, 3, 4, 9}));
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
    for (const double bad : {-1.0, -1e-300, 1.1e100, std::numeric_limits<double>::infinity(), std::nan("")}) {
        const auto density = grid(2, 2, {1, 1, bad, 1});
        ASSERT_FALSE(density) << bad;
        EXPECT_EQ(density.error().code, ErrorCode::Malformed);
        EXPECT_EQ(density.error().field, "values/2");
    }
    EXPECT_TRUE(grid(1, 2, {0, 1e100}));
}

TEST(Density, RefusesZeroEverywhere) {
    const auto density = grid(2, 1, {0, 0});
    ASSERT_FALSE(density);
    EXPECT_EQ(density.error().code, ErrorCode::Unusable);
}

}  // namespace
}  // namespace ccdt

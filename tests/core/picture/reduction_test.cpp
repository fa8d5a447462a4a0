// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/reduction.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

/// Returns irregular values in [0, 1].
std::vector<float> values(int count) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) values.push_back(static_cast<float>(i * 7919 % 1013) / 1012);
    return values;
}

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Reduction, AveragesWholePixels) {
    const std::vector<float> picture = {0, 1, 0.5F, 0.5F,  //
                                        1, 0, 0.5F, 0.25F};
    EXPECT_EQ(reduced(picture, 4, 2, {2, 1}), (std::vector<float>{0.5F, 0.4375F}));
}

TEST(Reduction, SplitsPixelsBetweenCells) {
    // Each cell has 1.5 x 1.5 pixels.
    const std::vector<float> picture = {1, 0, 0,  //
                                        0, 1, 0,  //
                                        0, 0, 0};
    const auto means = reduced(picture, 3, 3, {2, 2});
    const std::vector<float> expected = {1.25F / 2.25F, 0.25F / 2.25F, 0.25F / 2.25F, 0.25F / 2.25F};
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_FLOAT_EQ(means[i], expected[i]) << "cell " << i;
}

TEST(Reduction, PreservesSums) {
    for (const CellGrid cells :
         {CellGrid{20, 30}, CellGrid{37, 41}, CellGrid{1, 1}, CellGrid{96, 1}, CellGrid{97, 61}}) {
        const auto picture = values(97 * 61);
        const auto means = reduced(picture, 97, 61, cells);
        ASSERT_EQ(means.size(), static_cast<std::size_t>(cells.columns * cells.rows));
        const double area = 97.0 * 61 / (cells.columns * cells.rows);
        EXPECT_NEAR(sum(means) * area, sum(picture), 1e-6 * sum(picture)) << cells.columns << " x " << cells.rows;
    }
}

TEST(Reduction, LeavesFlatPicturesUnchanged) {
    for (const float value : {0.0F, 0.3F, 1.0F}) {
        for (const float mean : reduced(std::vector<float>(97 * 61, value), 97, 61, {37, 23})) EXPECT_EQ(mean, value);
    }
}

TEST(Reduction, IsIdentityIfCellsArePixels) {
    EXPECT_EQ(reduced(values(12), 4, 3, {4, 3}), values(12));
}

TEST(Reduction, WeightsPixelsByAlpha) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const ColourPicture picture{4, 1, {1, 0.5F, nan, 1}, {0, 0.5F, 0, 1}, {1, 1, 0, 7}, {0.25F, 0.75F, 0, nan}};
    const ColourPicture half = reduced(picture, {2, 1});
    EXPECT_EQ(half.width, 2);
    EXPECT_EQ(half.height, 1);
    EXPECT_EQ(half.alpha, (Plane{0.5F, 0}));
    EXPECT_EQ(half.red, (Plane{0.625F, 0}));
    EXPECT_EQ(half.green, (Plane{0.375F, 0}));
    EXPECT_EQ(half.blue, (Plane{1, 0}));
}

TEST(Reduction, KeepsOpaquePicturesOpaque) {
    const ColourPicture half = reduced({2, 1, {1, 0}, {0, 0}, {3, -1}, {}}, {1, 1});
    EXPECT_TRUE(half.alpha.empty());
    EXPECT_EQ(half.red, Plane{0.5F});
    EXPECT_EQ(half.blue, Plane{0.5F});
}

TEST(ResolvedCells, AreHalfRadiusWide) {
    EXPECT_EQ(resolved_cells(6000, 4000, 10), (CellGrid{1200, 800}));
    EXPECT_EQ(resolved_cells(6001, 4000, 10), (CellGrid{1201, 800}));
    EXPECT_EQ(resolved_cells(6000, 4000, 5.1), (CellGrid{2400, 1600}));
}

TEST(ResolvedCells, ArePixelsIfDotsAreSmall) {
    for (const double radius : {0.0, 1e-308, 3.9})
        EXPECT_EQ(resolved_cells(6000, 4000, radius), (CellGrid{6000, 4000}));
    EXPECT_EQ(resolved_cells(100, 4000, 50), (CellGrid{100, 4000}));
    EXPECT_EQ(resolved_cells(1, 1, 1e308), (CellGrid{1, 1}));
}

TEST(ResolvedCells, AreAtLeast64AcrossPicture) {
    EXPECT_EQ(resolved_cells(6400, 640, 1e308), (CellGrid{640, 64}));
}

}  // namespace
}  // namespace ccdt

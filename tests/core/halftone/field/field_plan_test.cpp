// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/field_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

constexpr CellGrid kCells{120, 80};

std::vector<float> picture(const auto& light) {
    std::vector<float> values;
    for (int y = 0; y < kCells.rows; ++y) {
        for (int x = 0; x < kCells.columns; ++x) values.push_back(static_cast<float>(light(x + 0.5, y + 0.5)));
    }
    return values;
}

std::vector<float> flat(double light) {
    return picture([light](double, double) { return light; });
}

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(FieldPlan, DerivesNumberFromRadiusAndBack) {
    const FieldPlan plan = plan_field({flat(0.5)}, kCells, {{}, 3.0, 0});
    EXPECT_NEAR(plan.sites, 0.5 * 9600 / (std::numbers::pi * 9), 1);
    EXPECT_NEAR(plan_field({flat(0.5)}, kCells, {170, {}, 0}).radius, 3, 0.01);
    EXPECT_LT(plan_field({flat(0.9)}, kCells, {{}, 3.0, 0}).sites, plan.sites);
    EXPECT_EQ(plan_field({flat(0.5)}, kCells, {{}, 0.1, 0, 0, 500}).sites, 500);
    EXPECT_TRUE(std::isfinite(plan_field({flat(0.5)}, kCells, {{}, 1e-308, 0}).sites));
}

TEST(FieldPlan, NeedsNoSitesForBlackAndWhite) {
    const auto halves = picture([](double x, double) { return x < 60 ? 0 : 1; });
    for (const double light : {0.0, 1.0}) EXPECT_EQ(plan_field({flat(light)}, kCells, {500, {}, 1}).sites, 0);
    EXPECT_EQ(minority_area({halves}), 0);
    EXPECT_NEAR(minority_area({flat(0.3), flat(0.8)}), 0.3 * 9600, 0.1);
}

TEST(FieldPlan, HasFewerSitesInTheDarkAndWhereDotsWouldBeTiny) {
    // Columns of light .01, .5 and .99, each 40 cells wide.
    const auto columns = picture([](double x, double) { return x < 40 ? 0.01 : x < 80 ? 0.5 : 0.99; });
    const auto shares = [&](double least) {
        const FieldPlan plan = plan_field({columns}, kCells, {1000, {}, 0, least});
        std::vector<double> part(3, 0);
        for (std::size_t i = 0; i < plan.density.size(); ++i)
            part[i % 120 / 40] += static_cast<double>(plan.density[i]);
        for (double& each : part) each /= sum(plan.density);
        return part;
    };
    const auto free = shares(0), limited = shares(2);
    EXPECT_GT(free[1], free[0]);
    // 3,200 cells of .01: at most 32 / 2 / 2 holes for 2 cells each, and 32 / 2 dots.
    EXPECT_GT(free[0], 0.1);
    EXPECT_LT(limited[0], 0.02);
    EXPECT_LT(limited[2], 0.04);
}

TEST(FieldPlan, StacksSetsOfInksFromDarkToLight) {
    const InkSet inks{{{0, 0.19F, 0.52F}, {1, 0.06F, 0.43F}, {1, 0.81F, 0}}};
    const LightPlanes light{flat(0.6), flat(0.4), flat(0.3)};
    const FieldPlan plan = plan_field(light, inks, kCells, {500, {}, 0});
    ASSERT_GE(plan.sets.size(), 4U);
    EXPECT_EQ(plan.sets.front(), 7U);
    EXPECT_EQ(plan.sets.back(), 0U);
    ASSERT_EQ(plan.channels.size(), plan.sets.size() - 1);
    for (std::size_t c = 1; c < plan.channels.size(); ++c)
        EXPECT_LE(plan.channels[c].light[0], plan.channels[c - 1].light[0]);
}

TEST(FieldPlan, UsesFewSetsOfManyInks) {
    const InkSet inks{
        {{0, 0.19F, 0.52F}, {1, 0.06F, 0.43F}, {1, 0.81F, 0}, {0, 0, 0}, {0, 0.4F, 0.1F}, {1, 0.2F, 0.03F}}};
    const LightPlanes light{picture([](double x, double) { return x / 120; }),
                            picture([](double, double y) { return y / 80; }), flat(0.3)};
    const FieldPlan plan = plan_field(light, inks, kCells, {500, {}, 0});
    EXPECT_LE(plan.sets.size(), kMaxInkSets);
    EXPECT_GE(plan.sets.size(), 5U);
    EXPECT_EQ(plan.channels.size(), plan.sets.size() - 1);
    EXPECT_EQ(plan.sets.back(), 0U);
}

}  // namespace
}  // namespace ccdt

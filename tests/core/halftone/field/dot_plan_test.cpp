// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/dot_plan.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr int kSide = 100;

using Cover = std::vector<float>;

Cover flat(float share) {
    return Cover(kSide * kSide, share);
}

/// Returns a coverage from white on the left to black on the right.
Cover ramp() {
    Cover cover;
    for (int i = 0; i < kSide * kSide; ++i) cover.push_back(static_cast<float>(i % kSide) / (kSide - 1));
    return cover;
}

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(PlanDots, DerivesRadiusFromNumberOfDots) {
    // Without overlaps, the areas of the discs add up to the wanted area.
    const DotPlan light = plan_dots({flat(0.3f)}, kSide, kSide, {.sites = 500, .radius = {}});
    EXPECT_NEAR(500 * kPi * light.radius * light.radius, 0.3 * kSide * kSide, 1);
    EXPECT_NEAR(light.tone, 1, 1e-9);
    const DotPlan black = plan_dots({flat(1)}, kSide, kSide, {.sites = 500, .radius = {}});
    EXPECT_NEAR(500 * kPi * black.radius * black.radius, 1.6 * kSide * kSide, 500);
    EXPECT_NEAR(black.tone, 1, 1e-3);
    for (const auto& plan : {light, black}) EXPECT_NEAR(sum(plan.dots), 500, 0.01);
}

TEST(PlanDots, DerivesNumberOfDotsFromRadius) {
    const DotPlan by_sites = plan_dots({ramp()}, kSide, kSide, {.sites = 700, .radius = {}});
    const DotPlan by_radius = plan_dots({ramp()}, kSide, kSide, {.sites = {}, .radius = by_sites.radius});
    EXPECT_NEAR(sum(by_radius.dots), 700, 0.5);
    EXPECT_EQ(by_radius.radius, by_sites.radius);
    EXPECT_NEAR(by_radius.tone, 1, 1e-3);
}

TEST(PlanDots, ScalesToneIfNumberAndRadiusAreGiven) {
    const double radius = std::sqrt(0.2 * kSide * kSide / (kPi * 500));
    const DotPlan half = plan_dots({flat(0.4f)}, kSide, kSide, {.sites = 500, .radius = radius});
    EXPECT_NEAR(half.tone, 0.5, 1e-3);
    EXPECT_NEAR(half.density[0][0], 0.05, 1e-4);
    const DotPlan more = plan_dots({ramp()}, kSide, kSide, {.sites = 3000, .radius = radius});
    EXPECT_GT(more.tone, 1.1);
    EXPECT_NEAR(sum(more.dots), 3000, 3);
    const DotPlan all = plan_dots({ramp()}, kSide, kSide, {.sites = 1'000'000, .radius = radius});
    EXPECT_NEAR(all.tone, 2, 0.05) << "the whole picture is solid";
}

TEST(PlanDots, CompensatesOverlapWithMoreDots) {
    const DotPlan plan = plan_dots({ramp()}, kSide, kSide, {.sites = 700, .radius = {}});
    const double area = kPi * plan.radius * plan.radius;
    const auto dots_at = [&](int x) {
        return area * static_cast<double>(plan.density[0][50 * kSide + static_cast<std::size_t>(x)]);
    };
    EXPECT_NEAR(dots_at(30), 30 / 99.0, 0.01);
    EXPECT_NEAR(dots_at(79), 0.81, 0.02);
    EXPECT_GT(dots_at(93), 1.04);
    EXPECT_EQ(dots_at(0), 0) << "no dots on white";
}

TEST(PlanDots, DistinguishesTextureFromTone) {
    // Black and white squares finer than the dots look grey, so their dots have the radius of those for grey.
    Cover squares;
    for (int i = 0; i < kSide * kSide; ++i) squares.push_back((i % kSide + i / kSide) % 2 == 0 ? 1.0f : 0.0f);
    const DotPlan fine = plan_dots({squares}, kSide, kSide, {.sites = 100, .radius = {}});
    EXPECT_NEAR(fine.radius, plan_dots({flat(0.5f)}, kSide, kSide, {.sites = 100, .radius = {}}).radius, 0.02);
    EXPECT_EQ(fine.density[0][1], 0) << "no dots on white squares";
}

TEST(PlanDots, UsesOneRadiusForAllInks) {
    const DotPlan plan = plan_dots({flat(0.4f), flat(0.1f), flat(0)}, kSide, kSide, {.sites = 500, .radius = {}});
    ASSERT_EQ(plan.dots.size(), 3U);
    EXPECT_NEAR(plan.dots[0], 400, 0.5);
    EXPECT_NEAR(plan.dots[1], 100, 0.5);
    EXPECT_EQ(plan.dots[2], 0);
}

TEST(PlanDots, AcceptsExtremeNumbersAndRadii) {
    Random random(1, 0);
    Cover cover = flat(0);
    for (float& share : cover) share = static_cast<float>(random.uniform());
    for (const std::size_t sites : {std::size_t{1}, std::size_t{100'000'000}}) {
        const DotPlan plan = plan_dots({cover}, kSide, kSide, {.sites = sites, .radius = {}});
        EXPECT_NEAR(plan.dots[0] / static_cast<double>(sites), 1, 1e-3);
        EXPECT_TRUE(plan.radius > 0 && plan.radius < kSide);
    }
    for (const double radius : {1e-3, 1e4}) {
        const DotPlan plan = plan_dots({cover}, kSide, kSide, {.sites = {}, .radius = radius});
        EXPECT_TRUE(plan.dots[0] > 0 && std::isfinite(plan.dots[0])) << radius;
    }
}

TEST(PlanDots, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const DotPlan plan = plan_dots({ramp()}, kSide, kSide, {.sites = 10, .radius = {}}, source.get_token());
    EXPECT_TRUE(plan.density.empty());
}

TEST(DotPlan, PlansALineByTheSquareOfDarkness) {
    const DotPlan by_sites = plan_dots({flat(0.399f)}, kSide, kSide, {.sites = 500, .radius = {}, .mark = Mark::Line});
    const double spacing = kSide / std::sqrt(500);
    EXPECT_NEAR(2 * by_sites.radius, 0.4 * spacing, 0.005 * spacing);
    const DotPlan by_width =
        plan_dots({flat(0.399f)}, kSide, kSide, {.sites = {}, .radius = by_sites.radius, .mark = Mark::Line});
    EXPECT_NEAR(by_width.dots.front(), 500, 1);
    const DotPlan two =
        plan_dots({flat(0.399f), flat(0.781f)}, kSide, kSide, {.sites = 500, .radius = {}, .mark = Mark::Line});
    EXPECT_NEAR(two.dots[1] / two.dots[0], 4, 0.05);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/clearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ccdt {
namespace {

TEST(DiscOnGround, ContainsNearerPointsTightly) {
    const Chart chart(direction_of({10, 50}));
    constexpr double kEquator = 6'378'137, kPole = 6'399'594;  // metres per radian of the conformal sphere
    for (const double metres : {1.0, 1e4, 1e6}) {
        for (const Point position : {Point{0, 0}, Point{0.1, 0}, Point{-0.3, 0.4}, Point{0, -1.5}, Point{20, 0}}) {
            const auto [centre, radius] = disc_on_ground(chart, position, metres);
            const Direction there = chart.to_direction(position);
            for (int i = 0; i < 16; ++i) {
                const double turn = i * std::numbers::pi / 8;
                const Point rim = centre + radius * Point{std::cos(turn), std::sin(turn)};
                const Direction away = chart.to_direction(rim) + -there;
                const double angle = 2 * std::asin(std::sqrt(dot(away, away)) / 2);
                EXPECT_GT(angle * kPole, metres);
                EXPECT_LT(angle * kEquator, 1.005 * metres);
            }
        }
    }
}

TEST(DiscOnGround, CoversPlaneIfItReachesAroundGlobe) {
    const Chart chart(direction_of({10, 50}));
    EXPECT_GT(disc_on_ground(chart, {0, 0}, 2.1e7).radius, 1e300);
    EXPECT_GT(disc_on_ground(chart, {0, 0}, 1e308).radius, 1e300);
}

TEST(KeepOffBorder, KeepsBufferWithCoarselySubdividedEdges) {
    constexpr double kMetresOfDegree = 111'694;  // along a meridian, at most
    const Ring cap{{-180, 85}, {180, 85}, {180, 90}, {-180, 90}};
    const Domain degrees = Domain::repair({{cap, {}}})->domain;
    for (const double buffer : {10.0, 1.0, 1e-3}) {
        ChartedPart part = std::move(chart_region(degrees, 50, buffer)->front());
        const std::size_t charted = part.domain.corner_count();
        ASSERT_TRUE(keep_off_border(part, buffer));
        EXPECT_LE(part.domain.corner_count(), 2 * charted);
        const Ring& ring = part.domain.rings().front();
        double least = 90, most = 0;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            for (const Point unit : {ring[i], 0.5 * (ring[i] + ring[(i + 1) % ring.size()])}) {
                const double latitude = position_of(part.chart.to_direction(part.domain.to_user(unit))).y;
                least = std::min(least, latitude - 85);
                most = std::max(most, latitude - 85);
            }
        }
        EXPECT_GT(least * kMetresOfDegree, buffer);
        EXPECT_LT(most * kMetresOfDegree, 1.02 * buffer + 1);
    }
}

TEST(KeepOffBorder, SimplifiesFineBorders) {
    constexpr int kCorners = 60'000;
    constexpr double kRadius = 0.1, kPitch = 1e-2, kBuffer = 1000;
    Ring ring;
    for (int i = 0; i < kCorners; ++i) {
        const double angle = 2 * std::numbers::pi * i / kCorners, radius = kRadius + (i % 2) * 1e-5;
        ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    ChartedPart part{Chart(direction_of({10, 45})), Domain::create({{{ring, {}}}}).value(), 0, 0, 1e-3 * kPitch};
    ASSERT_TRUE(keep_off_border(part, kBuffer));
    EXPECT_LT(part.domain.corner_count(), 2000U);
    const double bare = kRadius - kBuffer / 6.37e6, area = part.domain.area() / std::numbers::pi;
    EXPECT_LT(area, bare * bare);
    EXPECT_GT(area, std::pow(bare - 3e-2 * kPitch, 2));
}

TEST(KeepOffBorder, CutsOffDenseNeedles) {
    constexpr int kCorners = 60'000;
    constexpr double kInner = 0.1, kPitch = 1e-2, kMaxRadius = 6'399'594;
    for (const double length : {5e-4, 0.1}) {
        Ring ring;
        for (int i = 0; i < kCorners; ++i) {
            const double angle = 2 * std::numbers::pi * i / kCorners, radius = kInner + (i % 2) * length;
            ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        }
        for (const double buffer : {1.0, 1000.0}) {
            ChartedPart part{Chart(direction_of({10, 45})), Domain::create({{{ring, {}}}}).value(), 0, 0,
                             1e-3 * kPitch};
            ASSERT_TRUE(keep_off_border(part, buffer));
            EXPECT_LT(part.domain.corner_count(), 5000U) << length << ' ' << buffer;
            const double bare = kInner - buffer / kMaxRadius;
            EXPECT_GT(part.domain.area(), std::numbers::pi * std::pow(bare - kPitch / 8, 2)) << length << ' ' << buffer;
            for (const Ring& remaining : part.domain.rings()) {
                for (const Point& unit : remaining) {
                    const Point p = part.domain.to_user(unit);
                    EXPECT_LT(std::sqrt(dot(p, p)), bare) << length << ' ' << buffer;
                }
            }
        }
    }
}

}  // namespace
}  // namespace ccdt

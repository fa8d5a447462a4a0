// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/region.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

/// Returns the box between two longitudes and two latitudes.
Ring box(double west, double south, double east, double north) {
    return {{west, south}, {east, south}, {east, north}, {west, north}};
}

using Parts = std::vector<PolygonPart>;

const Ring kGlobe = box(-180, -90, 180, 90);

/// Returns the region of parts in degrees, processed as in a request.
Domain region(const Parts& parts) {
    return Domain::repair(unrolled(parts).value()).value().domain;
}

std::vector<ChartedPart> charted(const Parts& parts) {
    auto result = chart_region(region(parts), 1000);
    EXPECT_TRUE(result) << result.error().message;
    return result ? *std::move(result) : std::vector<ChartedPart>();
}

/// Returns the area on the ground in square kilometres, by a sum over a grid on the part's bounding box.
double area(const ChartedPart& part) {
    constexpr int kRows = 400;
    const Box& box = part.domain.bounds();
    double sum = 0;
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kRows; ++column) {
            const Point unit{(column + 0.5) / kRows, (row + 0.5) / kRows};
            const Point p{box.min.x + unit.x * box.width(), box.min.y + unit.y * box.height()};
            bool inside = false;
            for (const Ring& ring : part.domain.rings()) {
                for (std::size_t i = 0; i < ring.size(); ++i) {
                    const Point a = part.domain.to_user(ring[i]), b = part.domain.to_user(ring[(i + 1) % ring.size()]);
                    if ((a.y > p.y) == (b.y > p.y)) continue;
                    if (a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x) inside = !inside;
                }
            }
            if (inside) sum += part.chart.ground(p);
        }
    }
    return sum * box.width() * box.height() / kRows / kRows / 1e6;
}

/// Returns the area in square kilometres between two longitudes and two latitudes, by Simpson's rule on the ellipsoid.
double area_of_box(double west, double south, double east, double north) {
    constexpr double kDegree = 3.14159265358979323846 / 180, kRadius = 6378.137, kSquare = 0.00669437999014;
    constexpr int kSteps = 1000;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double latitude = (south + (north - south) * i / kSteps) * kDegree;
        const double w = 1 - kSquare * std::sin(latitude) * std::sin(latitude);
        const double value = (1 - kSquare) * std::cos(latitude) / (w * w);
        sum += value * (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2);
    }
    return kRadius * kRadius * sum / 3 * (north - south) / kSteps * kDegree * (east - west) * kDegree;
}

TEST(Unrolled, FollowsRingsAcrossTheMeridianOf180Degrees) {
    const Ring across{{179, 0}, {-179, 0}, {-179, 2}, {179, 2}};
    EXPECT_EQ(unrolled({{across, {}}})->front().outer, (Ring{{179, 0}, {181, 0}, {181, 2}, {179, 2}}));
    const Ring twice{{179, 0}, {-180, 0}, {180, 0}, {-179, 1}};
    EXPECT_EQ(unrolled({{twice, {}}})->front().outer, (Ring{{179, 0}, {180, 0}, {180, 0}, {181, 1}}));
    const Ring beyond{{179, 0}, {190, 0}, {190, 2}};
    EXPECT_EQ(unrolled({{beyond, {}}})->front().outer, beyond);
    EXPECT_EQ(unrolled({{kGlobe, {}}})->front().outer, kGlobe) << "an edge around the whole globe is kept";
}

TEST(Unrolled, ShiftsHolesToTheirRing) {
    const Ring outer{{170, 0}, {200, 0}, {200, 20}, {170, 20}}, hole = box(-175, 5, -170, 10);
    EXPECT_EQ(unrolled({{outer, {hole}}})->front().holes.front(), box(185, 5, 190, 10));
}

TEST(Unrolled, ClosesRingsAroundAPole) {
    const Ring south{{-120, -70}, {0, -65}, {120, -75}};
    const Ring expected{{-120, -70}, {0, -65}, {120, -75}, {240, -70}, {240, -90}, {-120, -90}};
    EXPECT_EQ(unrolled({{south, {}}})->front().outer, expected);
    EXPECT_EQ(unrolled({{{{0, 80}, {120, 80}, {-120, 80}}, {}}})->front().outer.back(), (Point{0, 90}));
    // The outer ring is smaller than the hole around the same pole, as in maps assembled from pieces. They are swapped.
    const Ring tip{{-120, -89}, {0, -89}, {120, -89}};
    const auto joined = unrolled({{tip, {south}}});
    EXPECT_EQ(joined->front().outer, expected);
}

TEST(Unrolled, RefusesPositionsOffTheGlobe) {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    for (const Point wrong : {Point{0, 91}, Point{0, -1e308}, Point{541, 0}, Point{-1e308, 0}, Point{nothing, 0}}) {
        const auto refused = unrolled({{{{0, 0}, {1, 0}, {1, 1}}, {{{0, 0}, wrong, {1, 1}}}}});
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::Unusable);
        EXPECT_EQ(refused.error().field, "/0/1/1");
    }
}

TEST(ChartRegion, ApproximatesCurvedEdges) {
    const auto parts = charted({{box(-100, 40, -60, 50), {}}});
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_GT(parts.front().domain.corner_count(), 10u);
    EXPECT_NEAR(area(parts.front()) / area_of_box(-100, 40, -60, 50), 1, 3e-3);
}

TEST(ChartRegion, LimitsTheAccuracyOfCurvedEdges) {
    const Domain degrees = Domain::create({{{{0, 0}, {2, 0}, {2, 1}, {0, 1}}, {}}}).value();
    const auto corners = [&](double buffer) {
        return chart_region(degrees, 100, buffer)->front().domain.corner_count();
    };
    EXPECT_GT(corners(1e-3), corners(1));
    EXPECT_LT(corners(1e-300), 1'000'000U);
}

TEST(ChartRegion, LimitsThePiecesForASmallBuffer) {
    const Domain cap = region({{box(-180, 85, 180, 90), {}}});
    for (const double buffer : {10.0, 1.0, 1e-3, 1e-300}) {
        const ChartedPart part = std::move(chart_region(cap, 50, buffer)->front());
        EXPECT_LT(part.domain.corner_count(), 11'000U) << buffer;
        EXPECT_GT(part.error, 0) << buffer;
        EXPECT_LT(part.error, 1) << buffer;
    }
    EXPECT_EQ(chart_region(cap, 50, 1000)->front().error, 0);
}

TEST(ChartRegion, ChartsDenseNeedles) {
    constexpr int kCorners = 100'000;
    Ring star;
    for (int i = 0; i < kCorners; ++i) {
        const double angle = 2 * std::numbers::pi * i / kCorners, radius = i % 2 == 0 ? 5 : 10;
        star.push_back({10 + radius * std::cos(angle), 45 + radius * std::sin(angle)});
    }
    const Domain degrees = Domain::create({{star, {}}}).value();
    const auto parts = chart_region(degrees, 50, 1);
    ASSERT_TRUE(parts);
    ASSERT_EQ(parts->size(), 1U);
    // Both edges of a needle bend to the same side by the same amount, so it is almost a triangle on the chart, too.
    const double area = degrees.area() * std::pow(std::numbers::pi / 180, 2) * std::cos(std::numbers::pi / 4);
    EXPECT_NEAR(parts->front().domain.area(), area, 0.02 * area);
    EXPECT_LE(parts->front().domain.corner_count(), 2U * kCorners);
}

TEST(ChartRegion, JoinsPartsAtTheMeridianOf180Degrees) {
    const Ring whole = box(170, -20, 190, 10);
    const Ring west = box(170, -20, 180, 10), east{{-180, -20}, {-170, -20}, {-170, 10}, {-180, 10}, {-180, 0}};
    for (const Parts& parts : {Parts{{whole, {}}}, Parts{{west, {}}, {east, {}}}}) {
        const auto charts = charted(parts);
        ASSERT_EQ(charts.size(), 1u);
        EXPECT_EQ(charts.front().domain.rings().size(), 1u);
        EXPECT_NEAR(area(charts.front()) / area_of_box(170, -20, 190, 10), 1, 3e-3);
    }
}

TEST(ChartRegion, JoinsRegionsAroundAPole) {
    for (const Ring& cap : {box(-180, -90, 180, -70), Ring{{0, -70}, {120, -70}, {240, -70}}}) {
        const auto charts = charted({{cap, {}}});
        ASSERT_EQ(charts.size(), 1u);
        EXPECT_EQ(charts.front().domain.rings().size(), 1u);
        EXPECT_NEAR(area(charts.front()) / area_of_box(-180, -90, 180, -70), 1, 5e-3);
    }
}

TEST(InOneTurn, WrapsPartsBeyondOneTurn) {
    const Domain wide = region({{box(-190, 0, -170, 10), {box(-182, 2, -178, 4)}}, {box(170, 20, 200, 30), {}}});
    const auto cut = in_one_turn(wide);
    ASSERT_TRUE(cut) << cut.error().message;
    EXPECT_EQ(cut->bounds().min.x, -180);
    EXPECT_EQ(cut->bounds().max.x, 180);
    EXPECT_NEAR(cut->area(), 200 - 8 + 300, 1e-9);
    const auto charts = chart_region(*cut, 1000);
    ASSERT_TRUE(charts) << charts.error().message;
    EXPECT_EQ(charts->front().domain.rings().size(), 3u) << "the two halves of the hole are joined";
    const Domain narrow = region({{box(100, 0, 200, 10), {}}});
    EXPECT_EQ(in_one_turn(narrow)->bounds().max.x, 200);
}

TEST(ChartRegion, CutsRegionsThatCoverTheGlobe) {
    for (const Parts& parts :
         {Parts{{kGlobe, {}}}, Parts{{kGlobe, {box(10, 40, 12, 42)}}}, Parts{{box(-180, -89, 180, 89), {}}}}) {
        const auto charts = charted(parts);
        ASSERT_EQ(charts.size(), 2u);
        EXPECT_NEAR((area(charts[0]) + area(charts[1])) / area_of_box(-180, -90, 180, 90), 1, 1e-2);
    }
    EXPECT_EQ(charted({{box(-180, -60, 180, 85), {}}}).size(), 1u) << "the region does not cover the south";
}

TEST(ChartRegion, RefusesTinyRegionsAndStops) {
    const auto message = [](const Parts& parts) { return chart_region(region(parts), 10).error().message; };
    EXPECT_EQ(message({{box(0, 0, 1e-9, 1e-9), {}}}), "the polygon is too small on the globe");
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(chart_region(region({{kGlobe, {}}}), 10, 0, stop.get_token()).error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/globe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/ccdt/globe/region.h"

namespace ccdt {
namespace {

/// Returns the box between two longitudes and two latitudes.
Ring box(double west, double south, double east, double north) {
    return {{west, south}, {east, south}, {east, north}, {west, north}};
}

Domain region(const Ring& ring) {
    return Domain::create(unrolled({{ring, {}}}).value()).value();
}

GlobeDistribution placed(const Domain& degrees, const Options& options, const Density& density = Density::uniform()) {
    auto result = distribute_on_globe(degrees, density, options, distribute);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
}

double share(const std::vector<Point>& points, auto test) {
    return static_cast<double>(std::ranges::count_if(points, test)) / static_cast<double>(points.size());
}

TEST(DistributeOnGlobe, IsEvenOnTheWholeGlobe) {
    const auto globe = placed(region(box(-180, -90, 180, 90)), {.sites = 4000});
    EXPECT_NEAR(globe.pitch * globe.pitch * 4000 / 510'065'621.724e6, 1, 1e-4) << "the ellipsoid's surface";
    ASSERT_EQ(globe.sites.points.size(), 4000u);
    for (const Point p : globe.sites.points) {
        ASSERT_LE(std::abs(p.x), 180);
        ASSERT_LE(std::abs(p.y), 90);
    }
    EXPECT_NEAR(share(globe.sites.points, [](Point p) { return p.y > 0; }), 0.5, 0.01);
    EXPECT_NEAR(share(globe.sites.points, [](Point p) { return p.x > 0; }), 0.5, 0.01);
    EXPECT_NEAR(share(globe.sites.points, [](Point p) { return p.y > 60; }), 0.0673, 0.004);
}

TEST(DistributeOnGlobe, WeightsTheGroundByADensity) {
    const std::vector<double> values{1, 3};
    const auto density = Density::grid(1, 2, std::span<const double>(values)).value();
    const auto north = placed(region(box(-180, -60, 180, 60)), {.sites = 2000}, density);
    EXPECT_NEAR(share(north.sites.points, [](Point p) { return p.y > 0; }), 0.75, 0.01);
    const std::vector<double> east{1, 3};
    const auto across = placed(region(box(160, -30, 200, 30)), {.sites = 2000},
                               Density::grid(2, 1, std::span<const double>(east)).value());
    EXPECT_NEAR(share(across.sites.points, [](Point p) { return p.x < 0; }), 0.75, 0.01);
}

TEST(DistributeOnGlobe, AppliesNoBufferAlongCuts) {
    const Domain world = region(box(-180, -90, 180, 90));
    const Options options{.sites = 500};
    const auto kept = distribute_on_globe(world, Density::uniform(), options, distribute, 1e5);
    ASSERT_TRUE(kept) << kept.error().message;
    EXPECT_EQ(kept->sites.points, placed(world, options).sites.points);
}

TEST(DistributeOnGlobe, AcceptsTheSmallestBuffers) {
    for (const double buffer : {1e-300, 1e-5, 1e-4, 1e-2}) {
        const auto kept =
            distribute_on_globe(region(box(0, 0, 1, 1)), Density::uniform(), {.sites = 20}, distribute, buffer);
        EXPECT_TRUE(kept) << buffer << ' ' << kept.error().message;
    }
}

TEST(DistributeOnGlobe, KeepsABufferWithManyCorners) {
    Ring coast;
    constexpr int kCorners = 20'000;
    for (int i = 0; i < kCorners; ++i) {
        const double turn = 2 * std::numbers::pi * i / kCorners, radius = i % 2 == 0 ? 10 : 9.99;
        coast.push_back({10 + radius * std::cos(turn), 45 + radius * std::sin(turn)});
    }
    for (const double buffer : {1e-3, 10.0}) {
        const auto kept = distribute_on_globe(region(coast), Density::uniform(), {.sites = 50}, distribute, buffer);
        EXPECT_TRUE(kept) << buffer << ' ' << kept.error().message;
    }
}

TEST(DistributeOnGlobe, JoinsTheMeshesOfTwoCharts) {
    const auto globe = placed(region(box(-180, -90, 180, 90)), {.sites = 500, .keep_mesh = true});
    const TriangleMesh& mesh = *globe.sites.mesh;
    for (std::size_t i = 0; i < 500; ++i) ASSERT_EQ(mesh.vertices[i], globe.sites.points[i]);
    std::vector<int> used(mesh.vertices.size());
    for (const auto& triangle : mesh.triangles) {
        for (const auto v : triangle) ++used.at(v);
    }
    EXPECT_EQ(std::ranges::count(used, 0), 0);
    ASSERT_EQ(mesh.boundary.size(), 2u);
    for (const auto& loop : mesh.boundary) {
        for (const auto v : loop) EXPECT_GE(v, 500u);
    }
}

/// Returns points in a cap around a centre, evenly distributed on the ground.
/// @param angle  angular radius of the cap
std::vector<Point> cap_of_points(Point centre, double angle, int count) {
    const Chart chart(direction_of(centre));
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        const double turned = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double away = std::acos(1 - (1 - std::cos(angle)) * (i + 0.5) / count), radius = 2 * std::tan(away / 2);
        points.push_back(position_of(chart.to_direction({radius * std::cos(turned), radius * std::sin(turned)})));
    }
    return points;
}

TEST(DistributeOnGlobe, DividesSitesByTheGroundThatFixedPointsLeave) {
    constexpr double kCap = 20 * std::numbers::pi / 180;  // angular radius of the cap that the second chart covers
    const Direction middle = direction_of({-150, -30});
    const auto is_in_cap = [&](Point p) { return dot(direction_of(p), middle) > std::cos(kCap); };
    const double all = 2000, due = (1 - std::cos(kCap)) / 2;  // the cap's share of the ground
    for (const int fixed : {15, 30, 60, 300}) {
        Options options{.sites = static_cast<std::size_t>(all) - static_cast<std::size_t>(std::min(fixed, 60))};
        options.fixed = cap_of_points({-150, -30}, kCap, fixed);
        const auto globe = placed(region(box(-180, -90, 180, 90)), options);
        ASSERT_EQ(globe.sites.points.size(), options.sites);
        const auto in_cap = std::ranges::count_if(globe.sites.points, is_in_cap);
        EXPECT_NEAR(static_cast<double>(in_cap), std::max(0.0, due * all - fixed), 0.1 * due * all) << fixed;
    }
}

TEST(DistributeOnGlobe, AcceptsOneSiteAndTheSmallestRegions) {
    EXPECT_EQ(placed(region(box(-180, -90, 180, 90)), {.sites = 1}).sites.points.size(), 1u);
    const Domain field = region(box(10, 60, 10.00001, 60.00001));
    for (const Point p : placed(field, {.sites = 100}).sites.points) {
        EXPECT_TRUE(p.x > 10 && p.x < 10.00001 && p.y > 60 && p.y < 60.00001);
    }
}

TEST(DistributeOnGlobe, IsDeterministic) {
    const Domain degrees = region(box(100, 0, 250, 70));
    EXPECT_EQ(placed(degrees, {.sites = 300}).sites.points, placed(degrees, {.sites = 300}).sites.points);
}

TEST(DistributeOnGlobe, StopsOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    const auto stopped = distribute_on_globe(region(box(0, 0, 90, 90)), Density::uniform(), {.sites = 10}, distribute,
                                             0, {.stop = stop.get_token()});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt

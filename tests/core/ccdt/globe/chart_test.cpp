// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/chart.h"

#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

void expect_equal(Direction a, Direction b) {
    EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

TEST(Chart, MapsEquivalentLongitudesToIdenticalBytes) {
    for (const double latitude : {-89.9, -30.0, 0.0, 45.5}) {
        expect_equal(direction_of({180, latitude}), direction_of({-180, latitude}));
        expect_equal(direction_of({-12.5, latitude}), direction_of({347.5, latitude}));
        expect_equal(direction_of({-12.5, latitude}), direction_of({-372.5, latitude}));
    }
    expect_equal(direction_of({0, 90}), direction_of({77, 90}));
    expect_equal(direction_of({0, -90}), {0, 0, -1});
}

TEST(Chart, InvertsDirections) {
    for (const double latitude : {-90.0, -89.999'999, -60.0, -1e-9, 0.0, 33.3, 89.9, 90.0}) {
        for (const double longitude : {-179.9, -90.0, 0.0, 1e-9, 122.2}) {
            const Point position = position_of(direction_of({longitude, latitude}));
            EXPECT_NEAR(position.y, latitude, 1e-12);
            if (std::abs(latitude) == 90) continue;
            EXPECT_NEAR(position.x, longitude, 1e-8);
        }
    }
}

TEST(Chart, RoundTripsThroughThePlane) {
    for (const Direction centre : {Direction{0, 0, 1}, direction_of({15, 65}), direction_of({-170, -3})}) {
        const Chart chart(centre);
        EXPECT_NEAR(chart.to_plane(centre).x, 0, 1e-15);
        for (const Point p : {Point{0.1, 0.2}, Point{-3, 4}, Point{0, -20}, Point{1e-6, 0}}) {
            const Point again = chart.to_plane(chart.to_direction(p));
            const double far = std::sqrt(dot(p, p));
            EXPECT_NEAR(again.x, p.x, 1e-12 * (1 + far * far * far));
            EXPECT_NEAR(again.y, p.y, 1e-12 * (1 + far * far * far));
        }
    }
}

/// The expected values and areal scales were computed by `proj +proj=stere +lat_0=65 +lon_0=15 +ellps=WGS84` of
/// PROJ 9.1.
TEST(Chart, EqualsTheStereographicProjectionOfProj) {
    struct Row {
        Point position, metres;
        double scale;
    };
    constexpr std::array<Row, 4> kRows = {{
        {{15, 65}, {0, 0}, 0.9999999999506229},
        {{31, 71}, {577380.2494809336, 745183.0565141042}, 1.0115077055280801},
        {{-170, 10.5}, {1458627.3694705477, 16401228.328283198}, 7.120003465137716},
        {{100, -45}, {23152353.45635229, -11643706.21904808}, 26.465983672467395},
    }};
    const Chart chart(direction_of({15, 65}));
    const double metres = std::sqrt(chart.ground({0, 0}));
    for (const Row& row : kRows) {
        const Point p = chart.to_plane(direction_of(row.position));
        EXPECT_NEAR(metres * p.x, row.metres.x, 1e-5);
        EXPECT_NEAR(metres * p.y, row.metres.y, 1e-5);
        EXPECT_NEAR(chart.ground({0, 0}) / chart.ground(p) / row.scale, 1, 1e-6)
            << "PROJ computes the scale by differences";
    }
}

}  // namespace
}  // namespace ccdt

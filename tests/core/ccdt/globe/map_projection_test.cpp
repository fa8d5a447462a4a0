// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/map_projection.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

Ring box(double west, double south, double east, double north) {
    return {{west, south}, {east, south}, {east, north}, {west, north}};
}

void expect_near(const MapProjection& map, Point position, Point expected) {
    const Point p = map(position);
    EXPECT_NEAR(p.x, expected.x, 1e-9);
    EXPECT_NEAR(p.y, expected.y, 1e-9);
}

// The expected values were computed by PROJ 9.1 with `+ellps=WGS84`, and divided by 111195.05197522942 m, which is a
// degree on the authalic sphere.

TEST(MapProjection, IsAzimuthalAroundTheMiddleOfARegion) {
    const std::vector<PolygonPart> parts = {{box(6.2, 45.8, 10.2, 47.8), {}}};
    const MapProjection map = MapProjection::fitting(parts);
    expect_near(map, {8.2, 46.8}, {0, 0});
    expect_near(map, {7.1, 46.2}, {-0.7635134432933494, -0.5945045353907248});
    expect_near(map, {400.5, 60.25}, {15.567517281873627, 16.888905898956722});
    expect_near(map, {-60, 10}, {-63.18624385722682, -10.176581689762074});
}

TEST(MapProjection, FindsTheShortestRangeOfLongitudes) {
    const auto middle_of = [](const std::vector<PolygonPart>& parts, double longitude) {
        return MapProjection::fitting(parts)({longitude, 45}).x;
    };
    EXPECT_NEAR(middle_of({{box(-125, 25, -100, 49), {}}, {box(-102, 25, -67, 49), {}}}, -96), 0, 1e-12);
    EXPECT_NEAR(middle_of({{box(-179, 60, -130, 70), {}}, {box(172, 51, 180, 53), {}}}, -159), 0, 1e-12);
    EXPECT_NEAR(
        middle_of({{box(-180, 60, -170, 70), {}}, {box(-100, 60, -90, 70), {}}, {box(100, 60, 270, 70), {}}}, 185), 0,
        1e-12);
}

TEST(MapProjection, IsCentredAtAPoleThatTheRegionSurrounds) {
    const std::vector<PolygonPart> parts = {{box(-180, -90, 180, -63), {}}};
    const MapProjection map = MapProjection::fitting(parts);
    expect_near(map, {10, -80}, {1.7418828051393913, 9.878708284691728});
    expect_near(map, {-120, -65.5}, {-21.13838305137591, -12.204251144945301});
}

TEST(MapProjection, IsEqualEarthForMoreThanAHemisphere) {
    const std::vector<PolygonPart> parts = {{box(-168, -55, -34, 72), {}}, {box(-34, -47, 190, 78), {}}};
    const MapProjection map = MapProjection::fitting(parts);
    expect_near(map, {11, 0}, {0, 0});
    expect_near(map, {100, 50.5}, {63.056573373719786, 54.2837668436296});
    expect_near(map, {-160, -77}, {-93.26884052402059, -72.6751155368255});
    expect_near(map, {11, 90}, {0, 75.47932618742894});
}

TEST(MapProjection, JoinsPartsAcrossTheAntimeridian) {
    const std::vector<PolygonPart> parts = {{box(177, -19, 180, -16), {}}, {box(-180, -19, -179, -16), {}}};
    const MapProjection map = MapProjection::fitting(parts);
    EXPECT_NEAR(map({179, -17.5}).x, 0, 1e-12);
    EXPECT_NEAR(map({-179, -17.5}).x, 2 * std::cos(17.5 * kDegree), 0.01);
}

TEST(MapProjection, KeepsAreasAtAnyPlace) {
    const std::vector<PolygonPart> country = {{box(-125, 25, -67, 49), {}}};
    const std::vector<PolygonPart> world = {{box(-180, -90, 180, 90), {}}};
    for (const auto& parts : {country, world}) {
        const MapProjection map = MapProjection::fitting(parts);
        for (const Point at : {Point{-96, 37}, Point{-70, 48}, Point{-120, 26}}) {
            const Ring ring = box(at.x, at.y, at.x + 0.5, at.y + 0.5);
            Ring drawn = {map(ring.front())};
            for (std::size_t i = 0; i < ring.size(); ++i) {
                for (int piece = 1; piece <= 8; ++piece)
                    drawn.push_back(map(ring[i] + piece / 8.0 * (ring[(i + 1) % ring.size()] - ring[i])));
            }
            double area = 0;
            for (std::size_t i = 1; i < drawn.size(); ++i) area += cross(drawn[i - 1], drawn[i]) / 2;
            const auto ground = Domain::create({{ring, {}}}).map(ground_area);
            EXPECT_NEAR(area / ground.value(), 1, 1e-5);
        }
    }
}

TEST(GroundArea, OfTheGlobeIsThatOfTheSphere) {
    const auto globe = Domain::create({{box(-180, -90, 180, 90), {}}});
    EXPECT_NEAR(ground_area(globe.value()), 4 * 180 * 180 / std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace ccdt

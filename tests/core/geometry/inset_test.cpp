// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/inset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stop_token>

#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;
using test::Parts;

Domain inset_of(const Parts& parts, double distance) {
    const auto domain = Domain::create(parts);
    EXPECT_TRUE(domain);
    const auto left = inset(*domain, distance);
    EXPECT_TRUE(left) << left.error().message;
    return *left;
}

/// Checks that corners of the new border have at least the given distance from the old border. Arcs are replaced by
/// polygons, so the distance may be up to 1 % larger.
void expect_distance(const Domain& left, const Parts& parts, double distance) {
    double least = 1e300, most = 0;
    for (const Ring& ring : left.rings()) {
        for (const Point& p : ring) {
            const double found = test::distance_to_border(parts, left.to_user(p));
            least = std::min(least, found);
            most = std::max(most, found);
        }
    }
    EXPECT_GE(least, distance);
    EXPECT_LE(most, 1.01 * distance);
}

TEST(Inset, ShrinksARectangle) {
    const Domain left = inset_of({{box(1, 2, 4, 3), {}}}, 0.5);
    EXPECT_NEAR(left.area(), 6, 1e-9);
    ASSERT_EQ(left.rings().size(), 1U);
    EXPECT_EQ(left.bounds().min, (Point{1, 2}));
    EXPECT_EQ(left.bounds().max, (Point{5, 5}));
}

TEST(Inset, SurroundsHolesByArcs) {
    const Parts parts = {{box(0, 0, 9, 9), {box(4, 4, 1, 1)}}};
    const Domain left = inset_of(parts, 1);
    EXPECT_NEAR(left.area(), 49 - 5 - std::numbers::pi, 0.02);
    EXPECT_LT(left.area(), 49 - 5 - std::numbers::pi);
    EXPECT_EQ(left.rings().size(), 2U);
    expect_distance(left, parts, 1);
}

TEST(Inset, SplitsWhereTheDomainIsNarrow) {
    // Two squares joined by a corridor of width 1.
    const Parts parts = {
        {{{0, 0}, {4, 0}, {4, 1}, {8, 1}, {8, 0}, {12, 0}, {12, 4}, {8, 4}, {8, 2}, {4, 2}, {4, 4}, {0, 4}}, {}}};
    EXPECT_EQ(inset_of(parts, 0.4).rings().size(), 1U);
    const Domain left = inset_of(parts, 0.6);
    EXPECT_EQ(left.rings().size(), 2U);
    expect_distance(left, parts, 0.6);
}

TEST(Inset, KeepsDistanceFromFineAndCoarseBorders) {
    for (const auto* name : {"Italy-110m.geojson", "Switzerland-10m.geojson", "South-Africa-50m.geojson"}) {
        const Parts parts = test::read_geojson(name);
        for (const double distance : {1e-9, 1e-3, 0.1, 0.3}) {
            SCOPED_TRACE(testing::Message() << name << ' ' << distance);
            expect_distance(inset_of(parts, distance), parts, distance);
        }
    }
}

TEST(Inset, ShrinksAFineCircle) {
    const Parts parts = {{test::circle({0, 0}, 1, 20'000), {}}};
    const Domain left = inset_of(parts, 0.5);
    EXPECT_NEAR(left.area(), 0.25 * std::numbers::pi, 0.01);
    expect_distance(left, parts, 0.5);
}

/// Returns a circle with reflex corners of different depths.
/// @param depth  largest depth, relative to the radius
Parts ragged_circle(int corners, double depth) {
    Ring ring = test::circle({0, 0}, 1, corners);
    double share = 0.5;
    for (Point& p : ring) {
        constexpr double kGoldenRatio = 0.6180339887498949;
        share = std::fmod(share + kGoldenRatio * (1 + share), 1.0);
        p = (1 - depth * share) * p;
    }
    return {{ring, {}}};
}

TEST(Inset, KeepsDistanceFromRaggedBorders) {
    const Parts parts = ragged_circle(1500, 0.1);
    for (const double distance : {1e-6, 1e-4, 3e-3, 1e-2, 3e-2, 0.1, 0.45}) {
        SCOPED_TRACE(testing::Message() << distance);
        expect_distance(inset_of(parts, distance), parts, distance);
    }
}

TEST(Inset, RemovesNoMoreThanNeededAtRaggedBorders) {
    const Parts parts = ragged_circle(1500, 0.1);
    for (const double distance : {3e-3, 3e-2, 0.3}) {
        const Domain left = inset_of(parts, distance);
        Parts left_parts;
        for (const Ring& ring : left.rings()) {
            Ring& user = left_parts.emplace_back().outer;
            for (const Point& p : ring) user.push_back(left.to_user(p));
        }
        int lost = 0, kept = 0;
        for (int i = 0; i < 60; ++i) {
            for (int j = 0; j < 60; ++j) {
                const Point p{(i - 29.5) / 30, (j - 29.5) / 30};
                if (!test::contains(parts, p) || test::distance_to_border(parts, p) < 1.01 * distance) continue;
                ++(test::contains(left_parts, p) ? kept : lost);
            }
        }
        EXPECT_GT(kept, 500) << distance;
        EXPECT_EQ(lost, 0) << distance;
    }
}

TEST(Inset, AcceptsManyCorners) {
    const Parts parts = ragged_circle(20'000, 0.1);
    for (const double distance : {1e-300, 1e-12, 1e-3, 0.1, 0.5})
        EXPECT_GT(inset_of(parts, distance).area(), 0.4) << distance;
}

TEST(Inset, KeepsDistanceWithManyCorners) {
    // At the smallest distance no offset lines meet. At the largest one many edges are too short to have one.
    const Parts parts = ragged_circle(12'000, 0.1);
    for (const double distance : {1e-8, 1e-6, 1e-5, 1e-4}) {
        const Domain left = inset_of(parts, distance);
        ASSERT_FALSE(left.rings().empty());
        const Ring& ring = left.rings().front();
        for (std::size_t i = 0; i < ring.size(); i += 40) {
            const double found = test::distance_to_border(parts, left.to_user(ring[i]));
            EXPECT_GE(found, distance);
            EXPECT_LE(found, 1.01 * distance);
        }
    }
}

TEST(Inset, RemovesAStripWithManyCorners) {
    constexpr double kDistance = 1e-5;
    const Parts parts = {{test::star({0, 0}, 1, 0.9999, 12'000), {test::star({0, 0}, 0.5, 0.4999, 12'000)}}};
    const Domain domain = Domain::create(parts).value(), left = inset_of(parts, kDistance);
    double perimeter = 0;
    for (const Ring& ring : {parts[0].outer, parts[0].holes[0]}) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point along = ring[(i + 1) % ring.size()] - ring[i];
            perimeter += std::sqrt(dot(along, along));
        }
    }
    EXPECT_EQ(left.rings().size(), 2U);
    EXPECT_NEAR((domain.area() - left.area()) / (kDistance * perimeter), 1, 0.01);
}

TEST(Inset, DropsSeparateLinesThatAreTooNear) {
    // A ring thinner than the distance, whose hole contains the offset line of its outer border; and a separate disc.
    const Parts parts = {{test::circle({0, 0}, 1, 12'000), {test::circle({0, 0}, 0.9999, 12'000)}},
                         {test::circle({3, 0}, 1, 12'000), {}}};
    const Domain left = inset_of(parts, 2e-4);
    ASSERT_EQ(left.rings().size(), 1U);
    EXPECT_NEAR(left.area(), std::numbers::pi * 0.9998 * 0.9998, 1e-5);
}

TEST(Inset, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const auto left = inset(Domain::create(ragged_circle(1500, 0.1)).value(), 0.1, 0, source.get_token());
    ASSERT_FALSE(left);
    EXPECT_EQ(left.error().code, ErrorCode::Stopped);
}

TEST(Inset, KeepsOutOfOffCentreDiscs) {
    const Parts parts = {{box(0, 0, 4, 4), {box(1, 1, 1, 1)}}};
    const auto shifted = [](Point p) { return Disc{{p.x + 0.125 * p.y, p.y}, 0.25 + 0.125 * p.x}; };
    const auto left = inset(Domain::create(parts).value(), shifted);
    ASSERT_TRUE(left) << left.error().message;
    double least = 9;
    for (const Ring& ring : left->rings()) {
        for (const Point& corner : ring) {
            for (const Ring& border : {parts[0].outer, parts[0].holes[0]}) {
                for (int i = 0; i < 4000; ++i) {
                    const Point a = border[static_cast<std::size_t>(i / 1000)],
                                b = border[static_cast<std::size_t>(i / 1000 + 1) % 4];
                    const auto [centre, radius] = shifted(a + i % 1000 / 1000.0 * (b - a));
                    const Point away = left->to_user(corner) - centre;
                    least = std::min(least, std::sqrt(dot(away, away)) / radius);
                }
            }
        }
    }
    EXPECT_GT(least, 1);
    EXPECT_LT(least, 1.01);
    EXPECT_EQ(inset(Domain::create(parts).value(),
                    [](Point p) {
                        return Disc{p, 0};
                    })
                  ->rings(),
              Domain::create(parts)->rings());
}

TEST(Inset, UsesOneDistanceForSimilarDiscs) {
    // Radii differ by a tenth from west to east. The centres of discs are a thousandth of the radius off their points.
    const Parts parts = ragged_circle(6'000, 0.1);
    const Domain domain = Domain::create(parts).value();
    for (const double size : {1e-6, 1e-4, 1e-2}) {
        const auto disc = [&](Point p) {
            const double radius = size * (1 + 0.05 * p.x);
            return Disc{{p.x + 1e-3 * radius, p.y}, radius};
        };
        const auto left = inset(domain, disc, 0.2 * size);
        ASSERT_TRUE(left) << left.error().message;
        double least = 9, most = 0;
        for (const Ring& ring : left->rings()) {
            for (std::size_t i = 0; i < ring.size(); i += 40) {
                const double distance = test::distance_to_border(parts, left->to_user(ring[i])) / size;
                least = std::min(least, distance);
                most = std::max(most, distance);
            }
        }
        EXPECT_GE(least, 1.05) << size;
        EXPECT_LE(most, 1.3) << size;
    }
}

TEST(Inset, LimitsTheFinenessOfArcs) {
    constexpr double kSize = 1e-7;
    const Parts parts = {{test::star({0, 0}, 1, 0.999, 12'000), {}}};
    const auto disc = [](Point p) { return Disc{p, kSize}; };
    const Domain domain = Domain::create(parts).value();
    EXPECT_LE(inset(domain, disc, kSize)->corner_count(), 3 * domain.corner_count());
}

TEST(Inset, CoarsensNeedlesThatAreTooFine) {
    constexpr double kInner = 0.5, kDistance = 1e-4, kIndifference = 1e-4;
    for (const int corners : {49'000, 100'000}) {
        const Domain domain = Domain::create({{test::star({0, 0}, 1, kInner, corners), {}}}).value();
        const auto left = inset(domain, kDistance, kIndifference);
        ASSERT_TRUE(left) << left.error().message;
        EXPECT_LT(left->corner_count(), 5'000U) << corners;
        for (const Ring& ring : left->rings()) {
            for (const Point& unit : ring) {
                const Point p = left->to_user(unit);
                const double radius = std::sqrt(dot(p, p));
                EXPECT_LT(radius, kInner) << corners;  // all needles are thinner than twice the distance
                EXPECT_GT(radius, kInner - kDistance - 125 * kIndifference) << corners;
            }
        }
    }
}

TEST(Inset, RefusesAnEmptyResult) {
    const Domain square = Domain::rectangle(4, 4).value();
    for (const double distance : {2.0, 3.0, 1e308}) {
        const auto left = inset(square, distance);
        ASSERT_FALSE(left) << distance;
        EXPECT_EQ(left.error().code, ErrorCode::Unusable);
    }
    EXPECT_TRUE(inset(square, 1.9));
}

TEST(LargestClearance, IsTheRadiusOfTheLargestInscribedCircle) {
    const auto largest = [](const Parts& parts) { return largest_clearance(Domain::create(parts).value()); };
    EXPECT_NEAR(largest({{box(3, 3, 4, 2), {}}}), 1, 0.01);
    EXPECT_NEAR(largest({{{{0, 0}, {3, 0}, {0, 4}}, {}}}), 1, 0.01);
    EXPECT_NEAR(largest({{box(0, 0, 8, 8), {box(1, 1, 6, 6)}}}), 2 - std::numbers::sqrt2, 0.01);
    for (const auto* name : {"Italy-110m.geojson", "South-Africa-50m.geojson"}) {
        const Parts parts = test::read_geojson(name);
        const double distance = largest(parts);
        EXPECT_GT(inset_of(parts, 0.98 * distance).area(), 0);
        EXPECT_FALSE(inset(Domain::create(parts).value(), 1.011 * distance));
    }
}

}  // namespace
}  // namespace ccdt

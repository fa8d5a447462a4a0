// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/domain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/predicates.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;
using test::Parts;

constexpr int kManyVertices = 100'000;

void expect_refused(const Parts& parts, const std::string& field) {
    const auto domain = Domain::create(parts);
    ASSERT_FALSE(domain);
    EXPECT_EQ(domain.error().code, ErrorCode::Unusable) << domain.error().message;
    EXPECT_EQ(domain.error().field, field) << domain.error().message;
    EXPECT_FALSE(domain.error().message.empty());
}

/// Expects an error with one of the given fields. Some errors may name either of two rings or vertices.
void expect_refused(const Parts& parts, const std::vector<std::string>& fields) {
    const auto domain = Domain::create(parts);
    ASSERT_FALSE(domain);
    EXPECT_EQ(domain.error().code, ErrorCode::Unusable) << domain.error().message;
    EXPECT_NE(std::find(fields.begin(), fields.end(), domain.error().field), fields.end())
        << domain.error().field << ": " << domain.error().message;
}

TEST(Domain, MeasuresARectangle) {
    const auto domain = Domain::rectangle(3, 2);
    ASSERT_TRUE(domain);
    EXPECT_DOUBLE_EQ(domain->area(), 6);
    EXPECT_DOUBLE_EQ(domain->unit_area(), 2.0 / 3);
    EXPECT_EQ(domain->bounds().width(), 3);
    EXPECT_EQ(domain->bounds().height(), 2);
    EXPECT_EQ(domain->unit_bounds().width(), 1);
    EXPECT_EQ(domain->corner_count(), 4u);
    EXPECT_TRUE(domain->is_box());
}

TEST(Domain, RefusesRectanglesWithoutSize) {
    for (const double bad : {0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        EXPECT_FALSE(Domain::rectangle(bad, 1)) << bad;
        EXPECT_FALSE(Domain::rectangle(1, bad)) << bad;
    }
}

TEST(Domain, SnapsCornersNearTheLowerSides) {
    const auto domain = Domain::create({PolygonPart{{{1e-45, 0}, {0.5, -5e-324}, {1, 0.5}, {0.5, 1}}, {}}});
    ASSERT_TRUE(domain) << domain.error().message;
    for (const Ring& ring : domain->rings()) {
        for (const Point& p : ring) {
            EXPECT_TRUE(p.x == 0 || p.x >= Domain::kMin) << p.x;
            EXPECT_TRUE(p.y == 0 || p.y >= Domain::kMin) << p.y;
        }
    }
}

TEST(Domain, JoinsTheSidesOfATorus) {
    const auto domain = Domain::torus(3, 2);
    ASSERT_TRUE(domain);
    EXPECT_TRUE(domain->is_torus());
    EXPECT_TRUE(domain->is_box());
    EXPECT_TRUE(domain->rings().empty());
    EXPECT_EQ(domain->corner_count(), 0u);
    EXPECT_EQ(domain->bounds().max, (Point{3, 2}));
    EXPECT_NEAR(domain->area(), 6, 1e-14);
    const Point sides = domain->unit_bounds().max;
    EXPECT_EQ(sides.x, 1);
    EXPECT_NEAR(sides.y, 2.0 / 3, 0x1p-50);
    EXPECT_EQ(sides, snapped(sides)) << "multiples of 2^-50";
    EXPECT_FALSE(Domain::rectangle(3, 2)->is_torus());
}

TEST(Domain, RefusesInvalidTori) {
    EXPECT_TRUE(Domain::torus(1, 1000));
    EXPECT_TRUE(Domain::torus(1000, 1));
    const double infinity = std::numeric_limits<double>::infinity();
    const std::vector<Point> bad{{1, 1000.01},  {1000.01, 1},      {0, 1},           {1, 0},
                                 {-1, 1},       {1, -1},           {infinity, 1},    {infinity, infinity},
                                 {1, infinity}, {std::nan(""), 1}, {1, std::nan("")}};
    for (const auto& [width, height] : bad) {
        const auto domain = Domain::torus(width, height);
        ASSERT_FALSE(domain) << width << " x " << height;
        EXPECT_EQ(domain.error().code, ErrorCode::Unusable);
    }
}

TEST(Domain, SubtractsHolesAndAddsParts) {
    const auto domain = Domain::create({{box(0, 0, 4, 4), {box(1, 1, 2, 2)}}, {box(6, 0, 2, 3), {}}});
    ASSERT_TRUE(domain);
    EXPECT_DOUBLE_EQ(domain->area(), 16 - 4 + 6);
    EXPECT_FALSE(domain->is_box());
}

TEST(Domain, AcceptsOpenAndClosedRingsOfBothOrientations) {
    Ring outer = test::u_shape(), hole = box(0.25, 0.25, 0.5, 0.5);
    for (const bool reverse_outer : {false, true}) {
        for (const bool reverse_hole : {false, true}) {
            for (const bool closed : {false, true}) {
                Ring o = outer, h = hole;
                if (reverse_outer) std::reverse(o.begin(), o.end());
                if (reverse_hole) std::reverse(h.begin(), h.end());
                if (closed) {
                    o.push_back(o.front());
                    h.push_back(h.front());
                }
                const auto domain = Domain::create({{o, {h}}});
                ASSERT_TRUE(domain) << domain.error().message;
                EXPECT_DOUBLE_EQ(domain->area(), 10 - 0.25);
                EXPECT_EQ(domain->corner_count(), 12u);
                EXPECT_EQ(orientation(domain->rings()[1][0], domain->rings()[1][1], domain->rings()[1][2]), -1)
                    << "holes run clockwise";
            }
        }
    }
}

TEST(Domain, DropsRepeatedVertices) {
    const Ring ring{{0, 0}, {0, 0}, {1, 0}, {1, 1}, {1, 1}, {1, 1}, {0, 1}, {0, 0}, {0, 0}};
    const auto domain = Domain::create({{ring, {}}});
    ASSERT_TRUE(domain);
    EXPECT_EQ(domain->corner_count(), 4u);
    EXPECT_TRUE(domain->is_box());
}

TEST(Domain, KeepsCollinearVertices) {
    const auto domain = Domain::create({{{{0, 0}, {0.25, 0}, {0.5, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}});
    ASSERT_TRUE(domain);
    EXPECT_EQ(domain->corner_count(), 6u);
    EXPECT_DOUBLE_EQ(domain->area(), 1);
}

TEST(Domain, ConvertsUnitPointsToUserCoordinates) {
    const auto domain = Domain::create({{box(100, -50, 8, 4), {}}});
    ASSERT_TRUE(domain);
    EXPECT_EQ(domain->to_user({0, 0}), (Point{100, -50}));
    EXPECT_EQ(domain->to_user({1, 0.5}), (Point{108, -46}));
}

TEST(Domain, MapsPeriodicCopiesToOnePoint) {
    const auto torus = Domain::torus(8, 4);
    ASSERT_TRUE(torus);
    for (const double x : {0.25, 1.25, -0.75}) {
        for (const double y : {0.375, 0.875, -0.125}) EXPECT_EQ(torus->to_user({x, y}), (Point{2, 3}));
    }
    EXPECT_EQ(torus->to_user({1, 0.5}), (Point{0, 0}));
    EXPECT_EQ(torus->to_user({-1e-20, -1e-20}), (Point{0, 0})) << "rounds to the upper sides";
}

TEST(Domain, IsInvariantUnderTranslationAndScaling) {
    const Parts parts = test::read_geojson("Italy-110m.geojson");
    const auto domain = Domain::create(parts);
    const auto large = Domain::create(test::scaled(parts, 0x1p30));
    const auto tiny = Domain::create(test::scaled(parts, 0x1p-30));
    ASSERT_TRUE(domain && large && tiny);
    EXPECT_EQ(domain->rings(), large->rings());
    EXPECT_EQ(domain->rings(), tiny->rings());
    EXPECT_EQ(domain->area() * 0x1p60, large->area());
}

TEST(Domain, ReadsCountries) {
    for (const char* name : {"Italy-110m.geojson", "South-Africa-50m.geojson", "Switzerland-10m.geojson"}) {
        const auto domain = Domain::create(test::read_geojson(name));
        EXPECT_TRUE(domain) << name << ": " << domain.error().message;
    }
}

TEST(Domain, AcceptsAnIslandInAHole) {
    const PolygonPart sea{box(0, 0, 10, 10), {box(2, 2, 6, 6)}}, island{box(4, 4, 2, 2), {}};
    for (const Parts& parts : {Parts{sea, island}, Parts{island, sea}}) {
        const auto domain = Domain::create(parts);
        ASSERT_TRUE(domain) << domain.error().message;
        EXPECT_DOUBLE_EQ(domain->area(), 100 - 36 + 4);
    }
}

TEST(Domain, AcceptsManyHoles) {
    const auto domain = Domain::create({test::sieve(20)});
    ASSERT_TRUE(domain);
    EXPECT_NEAR(domain->area(), 0.75, 1e-12);
}

TEST(Domain, RefusesNoPartsAtAll) {
    const auto domain = Domain::create({});
    ASSERT_FALSE(domain);
    EXPECT_EQ(domain.error().code, ErrorCode::Unusable);
}

TEST(Domain, RefusesTooFewVertices) {
    expect_refused({{{}, {}}}, "/0/0");
    expect_refused({{{{0, 0}, {1, 1}}, {}}}, "/0/0");
    expect_refused({{{{0, 0}, {1, 1}, {0, 0}}, {}}}, "/0/0");
    expect_refused({{box(0, 0, 1, 1), {}}, {box(2, 0, 1, 1), {{{2.2, 0.2}, {2.2, 0.2}, {2.4, 0.4}}}}}, "/1/1");
}

TEST(Domain, RefusesCoordinatesThatAreNotFinite) {
    const double inf = std::numeric_limits<double>::infinity();
    expect_refused({{{{0, 0}, {1, 0}, {std::nan(""), 1}}, {}}}, "/0/0/2");
    expect_refused({{box(0, 0, 1, 1), {{{0.2, 0.2}, {0.4, inf}, {0.2, 0.4}}}}}, "/0/1/1");
    expect_refused({{box(0, 0, 1, 1), {}}, {{{2, 0}, {2, 1}, {-inf, 0}}, {}}}, "/1/0/2");
}

TEST(Domain, RefusesZeroArea) {
    expect_refused({{{{0, 0}, {1, 1}, {2, 2}}, {}}}, "/0/0");
    expect_refused({{{{0, 0}, {3, 0}, {1, 0}, {2, 0}}, {}}}, "/0/0");
    expect_refused({{box(0, 0, 1, 1), {{{0.2, 0.2}, {0.3, 0.3}, {0.4, 0.4}}}}}, "/0/1");
}

TEST(Domain, RefusesExtentsThatNumbersCannotResolve) {
    EXPECT_FALSE(Domain::create({{box(1e16, 1e16, 64, 64), {}}}));
    EXPECT_FALSE(Domain::create({{box(0, 0, 1e200, 1e200), {}}}));
    EXPECT_FALSE(Domain::create({{box(0, 0, 1e-160, 1e-160), {}}}));
    EXPECT_FALSE(Domain::create({{box(-1.5e308, 0, 1.7e308, 1), {}}}));
    EXPECT_FALSE(Domain::rectangle(1.01e140, 1e140));
    EXPECT_FALSE(Domain::torus(0.99e-140, 0.99e-140));
}

TEST(Domain, KeepsSquaredLengthsFiniteAndNormal) {
    for (const double side : {1e-140, 1e140}) {
        for (const double shape : {1.0, 1e-11}) {
            const auto domain = Domain::rectangle(side, shape * side);
            ASSERT_TRUE(domain) << side;
            const double diagonal = std::hypot(side, shape * side);
            EXPECT_NEAR(domain->area() / (diagonal * diagonal), shape / (1 + shape * shape), 1e-15);
        }
    }
}

TEST(Domain, RefusesSelfCrossing) {
    expect_refused({{{{0, 0}, {4, 0}, {4, 4}, {1, -1}}, {}}}, std::vector<std::string>{"/0/0/0", "/0/0/2", "/0/0/3"});
}

TEST(Domain, RefusesABowTieWhoseAreasCancel) {
    expect_refused({{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, {}}}, std::vector<std::string>{"/0/0/0", "/0/0/2"});
}

TEST(Domain, RefusesAVertexOnAnEdge) {
    expect_refused({{{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, {}}}, std::vector<std::string>{"/0/0/0", "/0/0/3"});
}

TEST(Domain, RefusesARingThatPassesAVertexTwice) {
    expect_refused({{{{0, 0}, {2, 2}, {4, 0}, {4, 4}, {2, 2}, {0, 4}}, {}}},
                   std::vector<std::string>{"/0/0/1", "/0/0/4"});
}

TEST(Domain, RefusesSpikes) {
    expect_refused({{{{0, 0}, {2, 0}, {3, 0}, {2, 0}, {2, 2}, {0, 2}}, {}}},
                   std::vector<std::string>{"/0/0/1", "/0/0/2", "/0/0/3"});
}

TEST(Domain, CountsVerticesAsTheCallerDoes) {
    // The numbers of vertices include repeated and closing ones, and are those before the ring is reversed.
    const Ring ring{{0, 0}, {0, 0}, {0, 4}, {2, 2}, {4, 4}, {4, 0}, {2, 2}, {0, 0}};
    expect_refused({{ring, {}}}, std::vector<std::string>{"/0/0/3", "/0/0/6"});
}

TEST(Domain, RefusesHolesOutside) {
    expect_refused({{box(0, 0, 1, 1), {box(2, 2, 1, 1)}}}, "/0/1");
    expect_refused({{box(0, 0, 1, 1), {box(0.2, 0.2, 0.1, 0.1), box(-1, -1, 0.5, 0.5)}}}, "/0/2");
    expect_refused({{box(0, 0, 1, 1), {}}, {box(2, 0, 1, 1), {box(0.2, 0.2, 0.2, 0.2)}}}, "/1/1");
}

TEST(Domain, RefusesAHoleAroundItsPolygon) {
    EXPECT_FALSE(Domain::create({{box(1, 1, 1, 1), {box(0, 0, 3, 3)}}}));
}

TEST(Domain, RefusesHolesThatCrossTheOuterRing) {
    expect_refused({{box(0, 0, 1, 1), {box(0.5, 0.25, 1, 0.5)}}},
                   std::vector<std::string>{"/0/0/1", "/0/1/0", "/0/1/1", "/0/1/2", "/0/1/3"});
}

TEST(Domain, AcceptsRingsThatTouchAtPoints) {
    const Ring outer = box(0, 0, 4, 4);
    const Ring at_corner{{0, 0}, {2, 1}, {1, 2}}, at_edge{{2, 0}, {3, 1}, {1, 1}};
    for (const auto& [hole, area] : {std::pair{at_corner, 1.5}, {at_edge, 1.0}}) {
        const auto domain = Domain::create({{outer, {hole}}});
        ASSERT_TRUE(domain) << domain.error().message;
        EXPECT_DOUBLE_EQ(domain->area(), 16 - area);
    }
    const auto holes = Domain::create({{outer, {box(1, 1, 1, 1), box(2, 2, 1, 1)}}});
    ASSERT_TRUE(holes) << holes.error().message;
    EXPECT_DOUBLE_EQ(holes->area(), 14);
    const auto parts = Domain::create({{box(0, 0, 1, 1), {}}, {box(1, 1, 1, 1), {}}, {{{2, 0}, {2, 1}, {1, 0.5}}, {}}});
    ASSERT_TRUE(parts) << parts.error().message;
    EXPECT_DOUBLE_EQ(parts->area(), 2.5);
}

TEST(Domain, RefusesADisconnectedInside) {
    expect_refused({{box(0, 0, 4, 4), {{{2, 0}, {3, 2}, {2, 4}, {1, 2}}}}}, "/0/0");
}

TEST(Domain, RefusesHolesInHoles) {
    expect_refused({{box(0, 0, 8, 8), {box(1, 1, 6, 6), box(3, 3, 2, 2)}}}, "/0/2");
}

TEST(Domain, RefusesOverlappingParts) {
    expect_refused({{box(0, 0, 8, 8), {}}, {box(3, 3, 2, 2), {}}}, "/1/0");
    expect_refused({{box(3, 3, 2, 2), {}}, {box(0, 0, 8, 8), {}}}, "/1/0");
    EXPECT_FALSE(Domain::create({{box(0, 0, 2, 2), {}}, {box(1, 1, 2, 2), {}}}));
    EXPECT_FALSE(Domain::create({{box(0, 0, 2, 2), {}}, {box(0, 0, 2, 2), {}}}));
    EXPECT_FALSE(Domain::create({{box(0, 0, 2, 2), {}}, {box(2, 0, 2, 2), {}}})) << "a common edge";
}

TEST(Domain, AcceptsRingsOfManyVertices) {
    const auto domain = Domain::create({{test::circle({0, 0}, 1, kManyVertices), {}}});
    ASSERT_TRUE(domain);
    EXPECT_EQ(domain->corner_count(), static_cast<std::size_t>(kManyVertices));
    EXPECT_NEAR(domain->area(), 3.141592653589793, 1e-8);
}

TEST(Domain, AcceptsManyCollinearVertices) {
    for (const double slope : {0.0, 0.7}) {
        Ring ring;
        for (int i = 0; i <= kManyVertices / 4; ++i) {
            const double x = 4.0 * i / kManyVertices;
            ring.push_back({x, slope * x});
        }
        ring.push_back({0, 1});
        const auto domain = Domain::create({{ring, {}}});
        ASSERT_TRUE(domain) << domain.error().message;
        EXPECT_NEAR(domain->area(), 0.5, 1e-12);
    }
}

TEST(Domain, RefusesManyRandomCrossings) {
    Random random(1, 0);
    Ring ring;
    for (int i = 0; i < kManyVertices; ++i) ring.push_back({random.uniform(), random.uniform()});
    EXPECT_FALSE(Domain::create({{ring, {}}}));
}

TEST(Domain, StopsOnRequest) {
    std::stop_source stop;
    const Parts parts{{box(0, 0, 8, 8), {}}};
    EXPECT_TRUE(Domain::create(parts, stop.get_token()));
    stop.request_stop();
    const auto domain = Domain::create(parts, stop.get_token());
    ASSERT_FALSE(domain);
    EXPECT_EQ(domain.error().code, ErrorCode::Stopped);
}

TEST(Domain, IsEnclosedByChainsInAnyOrder) {
    const Ring outer = box(0, 0, 4, 2), hole{{1, 1}, {2, 1}, {2, 1.5}, {1, 1.5}};
    // A spike that runs back and forth across the ring.
    const Ring spike{{3, 1}, {9, 9}};
    const auto domain = Domain::enclosed_by({hole, spike, outer});
    ASSERT_TRUE(domain) << domain.error().message;
    EXPECT_DOUBLE_EQ(domain->area(), 7.5);
    EXPECT_EQ(domain->rings().size(), 2u);
    EXPECT_EQ(domain->bounds().max, (Point{4, 2}));
    // Shared edges enclose nothing.
    const auto joined = Domain::enclosed_by({box(0, 0, 1, 1), box(1, 0, 1, 1)});
    ASSERT_TRUE(joined) << joined.error().message;
    EXPECT_EQ(joined->rings().size(), 1u);
    EXPECT_DOUBLE_EQ(joined->area(), 2);
    EXPECT_EQ(Domain::enclosed_by({outer, outer}).error().code, ErrorCode::Unusable);
}

TEST(Domain, UnitesTouchingOverlappingAndSeparateDomains) {
    const Domain domains[] = {Domain::create({{box(0, 0, 4, 4), {box(1, 1, 2, 2)}}}).value(),
                              Domain::create({{box(1, 1, 1, 2), {}}}).value(),
                              Domain::create({{box(4, 0, 2, 4), {}}}).value(),
                              Domain::create({{box(5, 1, 2, 1), {}}, {box(9, 9, 1, 1), {}}}).value()};
    std::vector<const Domain*> all;
    for (const Domain& each : domains) all.push_back(&each);
    const auto united = Domain::united(all);
    ASSERT_TRUE(united) << united.error().message;
    EXPECT_DOUBLE_EQ(united->area(), 16 - 4 + 2 + 8 + 1 + 1);
    EXPECT_EQ(united->rings().size(), 3u);
    EXPECT_EQ(united->bounds().min, (Point{0, 0}));
    EXPECT_EQ(united->bounds().max, (Point{10, 10}));
    const Domain* alone = &domains[0];
    EXPECT_DOUBLE_EQ(Domain::united({&alone, 1})->area(), 12);
    std::stop_source stopped;
    stopped.request_stop();
    EXPECT_EQ(Domain::united(all, stopped.get_token()).error().code, ErrorCode::Stopped);
}

TEST(Domain, RefusesAreasTooThinForTheirCoordinates) {
    const auto thin = Domain::create({{{{1e9, 1e9}, {1e9 + 10, 1e9}, {1e9 + 10, 1e9 + 1e-5}, {1e9, 1e9 + 1e-5}}, {}}});
    ASSERT_FALSE(thin);
    EXPECT_EQ(thin.error().code, ErrorCode::Unusable);
    EXPECT_TRUE(Domain::create({{{{0, 0}, {10, 0}, {10, 1e-5}, {0, 1e-5}}, {}}}));
}

}  // namespace
}  // namespace ccdt

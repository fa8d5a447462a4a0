// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/repair.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;
using test::Parts;

RepairedDomain repaired(const Parts& parts) {
    auto result = Domain::repair(parts);
    EXPECT_TRUE(result) << result.error().message;
    return result ? *std::move(result) : RepairedDomain{Domain::rectangle(1, 1).value(), {}};
}

/// Whether a point is inside a domain, by the even-odd rule over all rings in the caller's coordinates.
bool is_inside(const Domain& domain, Point p) {
    const Box& bounds = domain.bounds();
    const double scale = std::max(bounds.width(), bounds.height());
    bool inside = false;
    for (const Ring& ring : domain.rings()) {
        inside ^= test::contains({{ring, {}}}, {(p.x - bounds.min.x) / scale, (p.y - bounds.min.y) / scale});
    }
    return inside;
}

/// Checks that a domain covers the same area as its parts, up to rounding.
void expect_same_area(const Domain& domain, const Parts& parts) {
    constexpr int kProbes = 400;
    constexpr double kNear = 1e-9;
    Random random(7, 0);
    const Box& bounds = domain.bounds();
    for (int i = 0; i < kProbes; ++i) {
        const Point p{bounds.min.x + random.uniform() * bounds.width(),
                      bounds.min.y + random.uniform() * bounds.height()};
        if (test::distance_to_border(parts, p) < kNear * bounds.width()) continue;
        EXPECT_EQ(is_inside(domain, p), test::contains(parts, p)) << p.x << ' ' << p.y;
    }
}

/// Checks that sites are placed, all inside, and that the mesh covers the domain.
void expect_sites_inside(const Domain& domain, const Parts& parts) {
    Options options;
    options.sites = 200;
    options.iterations = 2;
    options.keep_mesh = true;
    const auto set = distribute(domain, Density::uniform(), options);
    ASSERT_TRUE(set) << set.error().message;
    ASSERT_EQ(set->points.size(), options.sites);
    EXPECT_EQ(test::count_distinct(set->points), options.sites);
    for (const Point& p : set->points)
        EXPECT_TRUE(is_inside(domain, p) && test::contains(parts, p)) << p.x << ' ' << p.y;
    double area = 0;
    for (const auto& [a, b, c] : set->mesh->triangles) {
        const auto& at = set->mesh->vertices;
        area += cross(at[b] - at[a], at[c] - at[a]) / 2;
    }
    EXPECT_NEAR(area, domain.area(), 1e-9 * domain.area());
}

struct Case {
    const char* name;
    Parts parts;
    double area;
    std::vector<std::string> fields;  ///< fields of the reported faults
    std::string detail;               ///< text that the detail of the first fault contains
};

std::vector<Case> cases() {
    const Ring square = box(0, 0, 4, 4);
    return {
        {"bow tie", {{{{0, 0}, {4, 4}, {4, 0}, {0, 4}}, {}}}, 8, {"/0/0/2"}, "crosses itself at (2, 2)"},
        {"a vertex on an edge",
         {{{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, {}}},
         8,
         {"/0/0/0"},
         "touches itself at (2, 0)"},
        {"a vertex passed twice",
         {{{{0, 0}, {2, 2}, {4, 0}, {4, 4}, {2, 2}, {0, 4}}, {}}},
         8,
         {"/0/0/4"},
         "touches itself at (2, 2)"},
        {"a spike", {{{{0, 0}, {4, 0}, {9, 0}, {4, 0}, {4, 4}, {0, 4}}, {}}}, 16, {"/0/0/2"}, "runs along itself"},
        {"a spike inwards",
         {{{{0, 0}, {4, 0}, {4, 2}, {1, 2}, {4, 2}, {4, 4}, {0, 4}}, {}}},
         16,
         {"/0/0/3"},
         "runs along itself"},
        {"a ring traversed twice",
         {{{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {4, 0}, {4, 4}, {0, 4}}, {}}, {box(8, 0, 2, 2), {}}},
         4,
         {"/0/0"},
         "has no area"},
        {"parts that share an edge",
         {{box(0, 0, 2, 2), {}}, {box(2, 0, 2, 2), {}}},
         8,
         {"/1/0/3"},
         "runs along the outer ring of part 0 at (2, 1)"},
        {"parts that share some of an edge",
         {{box(0, 0, 2, 2), {}}, {box(2, 1, 2, 2), {}}},
         8,
         {"/1/0/3"},
         "runs along"},
        {"parts that overlap",
         {{box(0, 0, 2, 2), {}}, {box(1, 1, 2, 2), {}}},
         7,
         {"/1/0/0"},
         "crosses the outer ring of part 0 at (2, 1) and in another place"},
        {"a part in a part",
         {{box(0, 0, 8, 8), {}}, {box(3, 3, 2, 2), {}}},
         64,
         {"/1/0"},
         "overlaps the outer ring of part 0"},
        {"the same part twice", {{square, {}}, {square, {}}}, 16, {"/1/0/0"}, "runs along"},
        {"a hole that shares an edge", {{square, {box(1, 0, 1, 1)}}}, 15, {"/0/1/1"}, "hole 0 runs along"},
        {"a hole across the border", {{square, {box(3, 1, 2, 2)}}}, 14, {"/0/1/3"}, "hole 0 crosses"},
        {"a hole outside", {{square, {box(7, 7, 1, 1)}}}, 16, {"/0/1"}, "hole 0 lies outside its polygon"},
        {"a hole in a hole",
         {{square, {box(1, 1, 2, 2), box(1.5, 1.5, 1, 1)}}},
         12,
         {"/0/2"},
         "hole 1 overlaps hole 0"},
        {"holes that overlap",
         {{square, {box(1, 1, 1, 1), box(1.5, 1.5, 1, 1)}}},
         14.25,
         {"/0/2/1"},
         "hole 1 crosses hole 0"},
        {"a part along the border of a hole",
         {{square, {box(1, 1, 2, 2)}}, {box(1, 1, 1, 1), {}}},
         13,
         {"/1/0/0"},
         "runs along hole 0"},
        {"a hole that cuts its polygon",
         {{square, {{{2, 0}, {3, 2}, {2, 4}, {1, 2}}}}},
         12,
         {"/0/0"},
         "is cut into pieces"},
        {"a hole without area", {{square, {{{1, 1}, {2, 2}, {3, 3}}}}}, 16, {"/0/1"}, "hole 0 has no area at (3, 3)"},
        {"a part of one point",
         {{square, {}}, {{{9, 9}, {9, 9}}, {}}},
         16,
         {"/1/0"},
         "the outer ring of part 1 has no area at (9, 9)"},
        {"a part without points", {{square, {}}, {{}, {}}}, 16, {"/1/0"}, "the outer ring of part 1 has no area"},
    };
}

TEST(Repair, RepairsEachKindOfFault) {
    for (const Case& each : cases()) {
        SCOPED_TRACE(each.name);
        const RepairedDomain result = repaired(each.parts);
        EXPECT_NEAR(result.domain.area(), each.area, 1e-13 * each.area);
        std::vector<std::string> fields;
        for (const Repair& repair : result.repairs) fields.push_back(repair.field);
        EXPECT_EQ(fields, each.fields);
        ASSERT_FALSE(result.repairs.empty());
        EXPECT_NE(result.repairs.front().detail.find(each.detail), std::string::npos) << result.repairs.front().detail;
        expect_same_area(result.domain, each.parts);
        expect_sites_inside(result.domain, each.parts);
        EXPECT_FALSE(Domain::create(each.parts));
    }
}

TEST(Repair, ReportsNoFaultsOfValidPolygons) {
    const Ring square = box(0, 0, 4, 4);
    const std::vector<Parts> valid{{{square, {}}},
                                   {{square, {{{0, 0}, {2, 1}, {1, 2}}}}},
                                   {{square, {{{2, 0}, {3, 1}, {1, 1}}}}},
                                   {{square, {box(1, 1, 1, 1), box(2, 2, 1, 1)}}},
                                   {{box(0, 0, 2, 2), {}}, {box(2, 2, 2, 2), {}}},
                                   {{square, {box(1, 1, 2, 2)}}, {{{2, 1}, {3, 2}, {2, 3}, {1, 2}}, {}}}};
    for (const Parts& parts : valid) {
        const RepairedDomain result = repaired(parts);
        EXPECT_TRUE(result.repairs.empty()) << result.repairs.front().detail;
        expect_same_area(result.domain, parts);
        expect_sites_inside(result.domain, parts);
    }
}

/// Three sectors of the interior meet at one point, and a corner of one ring lies on an edge of another ring.
TEST(Repair, SeparatesFansAtACommonCorner) {
    Parts fans;
    for (int i = 0; i < 3; ++i) {
        const double from = 2.1 * i, to = from + 1;
        fans.push_back(
            {{{0.3, 0.7}, {0.3 + std::cos(from), 0.7 + std::sin(from)}, {0.3 + std::cos(to), 0.7 + std::sin(to)}}, {}});
    }
    const RepairedDomain result = repaired(fans);
    EXPECT_TRUE(result.repairs.empty());
    EXPECT_EQ(result.domain.rings().size(), 3u);
    expect_sites_inside(result.domain, fans);
}

/// Rings that touch in the caller's coordinates count as touching, however the unit frame rounds them.
TEST(Repair, TreatsRoundedContactsAsTouching) {
    Random random(3, 0);
    for (int i = 0; i < 200; ++i) {
        const double x = random.uniform() * 1000, y = random.uniform() * 1000, side = 1 + random.uniform();
        // The hole's corner is the midpoint of an edge, as exactly as doubles allow.
        const Point a{x, y}, b{x + side, y + side / 3}, c{x, y + 2 * side};
        const Point middle = 0.5 * (a + b);
        const Ring hole{middle, {x + 0.2 * side, y + 0.9 * side}, {x + 0.15 * side, y + 0.8 * side}};
        const RepairedDomain result = repaired({{{a, b, c}, {hole}}});
        EXPECT_TRUE(result.repairs.empty()) << result.repairs.front().detail;
    }
}

TEST(Repair, DropsDistantSpikes) {
    const Ring spiked{{0, 0}, {1, 0}, {1e6, 1e6}, {1, 0}, {1, 1}, {0, 1}};
    const RepairedDomain result = repaired({{spiked, {}}});
    EXPECT_EQ(result.domain.bounds().max, (Point{1, 1}));
    EXPECT_EQ(result.domain.unit_bounds().max, (Point{1, 1}));
    EXPECT_NEAR(result.domain.area(), 1, 1e-9);
    expect_sites_inside(result.domain, {{box(0, 0, 1, 1), {}}});
}

/// Rings cross everywhere, often at rounded crossings of other rings.
TEST(Repair, RepairsScribbles) {
    for (const int corners : {5, 8, 20, 60, 120}) {
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
            Random random(seed, static_cast<std::uint64_t>(corners));
            Parts parts(1 + seed % 3);
            const double grid = seed % 4 == 0 ? 8 : 0;  // puts corners on each other and on edges
            const auto any = [&] {
                const double value = random.uniform();
                return grid > 0 ? std::floor(grid * value) : value;
            };
            for (PolygonPart& part : parts) {
                for (int i = 0; i < corners; ++i) part.outer.push_back({any(), any()});
                part.holes.push_back({{any(), any()}, {any(), any()}, {any(), any()}, {any(), any()}});
            }
            const auto result = Domain::repair(parts);
            ASSERT_TRUE(result) << result.error().message << " with " << corners << " corners, seed " << seed;
            EXPECT_FALSE(result->repairs.empty());
            expect_same_area(result->domain, parts);
        }
    }
}

TEST(Repair, RefusesPolygonsWithoutArea) {
    const std::vector<std::pair<Parts, std::string>> flat{
        {{{{{0, 0}, {1, 1}, {2, 2}}, {}}}, "/0/0"},
        {{{{{0, 0}, {3, 0}, {1, 0}, {2, 0}}, {}}}, "/0/0"},
        {{{{{5, 5}}, {}}}, "/0/0"},
        {{{{}, {}}}, "/0/0"},
        {{{box(0, 0, 1, 1), {box(-1, -1, 3, 3)}}}, ""},
        {{{{{0, 0}, {1, 1}}, {}}, {{{0, 3}, {0, 4}}, {}}}, ""},
    };
    for (const auto& [parts, field] : flat) {
        const auto result = Domain::repair(parts);
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_EQ(result.error().field, field);
        EXPECT_NE(result.error().message.find("no area"), std::string::npos) << result.error().message;
    }
}

TEST(Repair, RefusesTooManyCrossings) {
    Random random(1, 0);
    Ring ring;
    for (int i = 0; i < 20'000; ++i) ring.push_back({random.uniform(), random.uniform()});
    const auto result = Domain::repair({{ring, {}}});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_NE(result.error().message.find("too often"), std::string::npos) << result.error().message;
}

TEST(Repair, ListsAHundredFaultsAndCountsTheRest) {
    Parts parts;
    for (int i = 0; i < 250; ++i)
        parts.push_back({{{2.0 * i, 0}, {2.0 * i + 1, 1}, {2.0 * i + 1, 0}, {2.0 * i, 1}}, {}});
    const RepairedDomain result = repaired(parts);
    ASSERT_EQ(result.repairs.size(), 101u);
    EXPECT_EQ(result.repairs[99].field, "/99/0/2");
    EXPECT_EQ(result.repairs.back().field, "");
    EXPECT_EQ(result.repairs.back().detail, "150 more such faults");
}

TEST(Repair, StopsOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    const auto result = Domain::repair({{{{0, 0}, {4, 4}, {4, 0}, {0, 4}}, {}}}, stop.get_token());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/difference.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/ccdt/plane/ccdt.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;

Domain square() {
    return Domain::rectangle(4, 4).value();
}

TEST(Without, SubtractsAreas) {
    const std::vector<Area> areas = {{box(1, 1, 1, 1)}, {box(3, -1, 4, 2)}};
    const auto remaining = without(square(), areas);
    ASSERT_TRUE(remaining) << remaining.error().message;
    EXPECT_DOUBLE_EQ(remaining->area(), 16 - 1 - 1);
    EXPECT_EQ(remaining->rings().size(), 2U);
    EXPECT_FALSE(remaining->is_box());
}

TEST(Without, KeepsTheBoundingBox) {
    const std::vector<Area> areas = {{box(-1, -1, 3, 9)}};
    const auto remaining = without(square(), areas);
    ASSERT_TRUE(remaining);
    EXPECT_DOUBLE_EQ(remaining->area(), 8);
    EXPECT_EQ(remaining->bounds().min, (Point{0, 0}));
    EXPECT_EQ(remaining->bounds().max, (Point{4, 4}));
    EXPECT_EQ(remaining->to_user({0.75, 0.5}), (Point{3, 2}));
}

TEST(Without, SubtractsTheUnionOfEvenOddAreas) {
    const std::vector<Area> areas = {{box(0, 0, 3, 3), box(1, 1, 1, 1)}, {box(2, 2, 2, 2)}};
    const auto remaining = without(square(), areas);
    ASSERT_TRUE(remaining);
    EXPECT_DOUBLE_EQ(remaining->area(), 16 - (9 - 1) - (4 - 1));
}

TEST(Without, ReturnsUntouchedDomainsUnchanged) {
    const std::vector<Area> areas = {{box(5, 5, 1, 1)}, {}, {{{-1, -1}, {-2, 9}}}};
    const auto remaining = without(square(), areas);
    ASSERT_TRUE(remaining);
    EXPECT_EQ(remaining->rings(), square().rings());
    EXPECT_TRUE(remaining->is_box());
}

TEST(Without, RefusesAFullyCoveredDomain) {
    const std::vector<Area> areas = {{box(-1, -1, 6, 6)}};
    const auto remaining = without(square(), areas);
    ASSERT_FALSE(remaining);
    EXPECT_EQ(remaining.error().code, ErrorCode::Unusable);
}

TEST(Without, ClipsDistantCornersAlongTheirEdges) {
    // The edge through the centre of the square joins two distant corners.
    for (const double far : {1e3, 1e9, 1e140}) {
        const std::vector<Area> areas = {{{{-far, -far}, {far, far}, {far, -far}}}};
        const auto remaining = without(square(), areas);
        ASSERT_TRUE(remaining) << far << remaining.error().message;
        EXPECT_NEAR(remaining->area(), 8, 1e-12) << far;
    }
    const double most = std::numeric_limits<double>::max();
    const std::vector<Area> all = {{box(-most, -most, most, most), box(2, 2, most, most)}};
    EXPECT_NEAR(without(square(), all)->area(), 12, 1e-12);
}

TEST(Without, ContainsNoPointOfTheAreas) {
    const auto italy = test::read_geojson("Italy-110m.geojson");
    const auto domain = Domain::create(italy);
    ASSERT_TRUE(domain);
    const Ring lake = test::star({12.5, 42.5}, 1, 0.3, 24);
    const std::vector<Area> areas = {{lake}, {box(15, 35, 5, 5)}};
    const auto remaining = without(*domain, areas);
    ASSERT_TRUE(remaining) << remaining.error().message;
    Options options;
    options.sites = 2000;
    const auto placed = distribute(*remaining, Density::uniform(), options);
    ASSERT_TRUE(placed) << placed.error().message;
    EXPECT_EQ(placed->points.size(), 2000U);
    EXPECT_EQ(test::count_outside(italy, placed->points), 0U);
    EXPECT_EQ(test::count_outside({{lake, {}}, {box(15, 35, 5, 5), {}}}, placed->points), 2000U);
}

TEST(RepairedArea, KeepsValidInputAndRepairsOther) {
    const std::vector<PolygonPart> valid = {{box(0, 0, 3, 3), {box(1, 1, 1, 1)}}};
    const auto kept = Domain::repair_area(valid);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->rings, (Area{box(0, 0, 3, 3), box(1, 1, 1, 1)}));
    EXPECT_TRUE(kept->repairs.empty());
    const auto repaired = Domain::repair_area({{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, {}}});
    ASSERT_TRUE(repaired);
    EXPECT_EQ(repaired->rings.size(), 2U);
    ASSERT_EQ(repaired->repairs.size(), 1U);
    EXPECT_EQ(repaired->repairs[0].field, "/0/0/2");
}

TEST(RepairedArea, MayBeTooSmallForADomain) {
    const std::vector<PolygonPart> ponds = {{box(0, 0, 1e-8, 1e-8), {}}, {box(9, 9, 1e-8, 1e-8), {}}};
    EXPECT_FALSE(Domain::create(ponds));
    const auto area = Domain::repair_area(ponds);
    ASSERT_TRUE(area);
    EXPECT_EQ(area->rings.size(), 2U);
}

}  // namespace
}  // namespace ccdt

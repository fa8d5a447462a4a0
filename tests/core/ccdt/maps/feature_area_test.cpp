// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/feature_area.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"
#include "core/ccdt/maps/feature_index.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::Parts;

FeatureArea area_of(const Parts& parts) {
    return FeatureArea(Domain::create(parts).value());
}

TEST(FeatureArea, AgreesWithExactPredicates) {
    const Parts shapes[] = {{{test::star({3, 2}, 2, 0.7, 40), {test::circle({3, 2}, 0.5, 17)}}},
                            {test::sieve(5)},
                            test::read_geojson("South-Africa-50m.geojson"),
                            {{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}, {{{1, 1}, {2, 1}, {2, 2}, {1, 2}}, {}}}};
    for (const Parts& parts : shapes) {
        const Domain domain = Domain::create(parts).value();
        const FeatureArea area(domain);
        const Box& box = domain.bounds();
        Random random(1, 0);
        int inside = 0;
        for (int i = 0; i < 2000; ++i) {
            const Point p{box.min.x + (1.2 * random.uniform() - 0.1) * box.width(),
                          box.min.y + (1.2 * random.uniform() - 0.1) * box.height()};
            EXPECT_EQ(area.contains(p), test::contains(parts, p)) << p.x << ' ' << p.y;
            inside += area.contains(p) ? 1 : 0;
        }
        EXPECT_GT(inside, 100);
    }
}

TEST(FeatureArea, GivesTheSameAnswersWithAGrid) {
    const Parts shapes[] = {{{test::star({3, 2}, 2, 0.7, 40), {test::circle({3, 2}, 0.5, 17)}}},
                            {test::sieve(5)},
                            test::read_geojson("South-Africa-50m.geojson"),
                            {{test::box(0, 0, 1000, 1), {}}}};
    for (const Parts& parts : shapes) {
        const Domain domain = Domain::create(parts).value();
        const Box& box = domain.bounds();
        const double size = std::min(box.width(), box.height());
        const auto clearance = [&](Point middle, Point) {
            return middle.x < box.min.x + box.width() / 2 ? 0.02 * size : 0;
        };
        const FeatureArea area(domain, clearance);
        for (const std::size_t cells : {1, 40, 2000, 100000}) {
            const FeatureArea gridded(domain, clearance, cells);
            Random random(4, cells);
            for (int i = 0; i < 4000; ++i) {
                const Point p = box.min + Point{random.uniform() * box.width(), random.uniform() * box.height()};
                EXPECT_EQ(gridded.position_of(p), area.position_of(p)) << p.x << ' ' << p.y << ' ' << cells;
            }
        }
    }
}

TEST(FeatureArea, ExcludesTheBorder) {
    const Parts parts = {{test::l_shape(), {}}};
    const FeatureArea area = area_of(parts);
    const Ring& ring = parts.front().outer;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point next = ring[(i + 1) % ring.size()];
        EXPECT_FALSE(area.contains(ring[i]));
        EXPECT_FALSE(area.contains(0.5 * (ring[i] + next)));
    }
}

TEST(FeatureArea, SlidesAlongAnObstructingBorder) {
    const FeatureArea area = area_of({{test::box(0, 0, 4, 1), {}}});
    EXPECT_EQ(area.towards({1, 0.5}, {2, 0.25}), (Point{2, 0.25}));
    EXPECT_EQ(area.towards({1, 0.5}, {2, 1.5}), (Point{2, 0.5}));
}

TEST(FeatureArea, NeverLeavesTheArea) {
    const Parts parts = {{test::star({0, 0}, 1, 0.3, 16), {}}};
    const FeatureArea area = area_of(parts);
    Random random(2, 0);
    Point at{0, 0};
    for (int i = 0; i < 5000; ++i) {
        at = area.towards(at, at + Point{random.uniform() - 0.5, random.uniform() - 0.5});
        ASSERT_TRUE(test::contains(parts, at));
    }
}

TEST(FeatureIndex, FindsAllFeaturesAtAPosition) {
    std::vector<FeatureArea> areas;
    for (int i = 0; i < 40; ++i) areas.push_back(area_of({{test::box(i % 8, i / 8, 1.5, 1.5), {}}}));
    const FeatureIndex index(areas);
    Random random(3, 0);
    for (int i = 0; i < 500; ++i) {
        const Point p{10 * random.uniform(), 7 * random.uniform()};
        std::vector<bool> near(areas.size(), false);
        index.for_near(p, [&](std::uint32_t area) { near[area] = true; });
        for (std::size_t area = 0; area < areas.size(); ++area) {
            if (areas[area].contains(p)) {
                EXPECT_TRUE(near[area]);
            }
        }
    }
}

}  // namespace
}  // namespace ccdt

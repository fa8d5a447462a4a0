// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_layer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/maps/feature_index.h"
#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

/// A dense and a sparse square side by side, with their dots, as dot maps prepare them.
struct TwoSquares {
    TwoSquares()
        : features{{test::domain_of({{test::box(0, 0, 1, 1)}}), {300}},
                   {test::domain_of({{test::box(1, 0, 1, 1)}}), {60}}},
          areas{FeatureArea(features[0].area), FeatureArea(features[1].area)},
          index(areas),
          ground(DotGround::create({features, areas, index, box, density, {}}, 0, inline_executor(), {}).value()),
          layer(ground, test::domain_of({{test::box(0, 0, 2, 1)}}), Options{}, Control{}) {}
    TwoSquares(const TwoSquares&) = delete;
    TwoSquares& operator=(const TwoSquares&) = delete;

    /// Checks that each feature has its dots, strictly inside.
    void check() {
        std::vector<std::size_t> counts(2, 0);
        for (std::size_t dot = 0; dot < layer.size(); ++dot) {
            const std::uint32_t feature = layer.feature_of(dot);
            const Point p = layer.position(dot);
            ++counts[feature];
            EXPECT_TRUE(p.x > feature && p.x < feature + 1 && p.y > 0 && p.y < 1) << p.x << ' ' << p.y;
        }
        EXPECT_EQ(counts, (std::vector<std::size_t>{300, 60}));
    }

    std::vector<MapFeature> features;
    std::vector<FeatureArea> areas;
    FeatureIndex index;
    Box box{{0, 0}, {2, 1}};
    Density density = Density::uniform();
    DotGround ground;
    DotLayer layer;
};

TEST(DotLayer, StartsWithTheDotsOfEachFeature) {
    TwoSquares map;
    ASSERT_TRUE(map.layer.start());
    map.check();
}

TEST(DotLayer, EqualisesTheAreasOfDots) {
    TwoSquares map;
    ASSERT_TRUE(map.layer.start());
    ASSERT_TRUE(map.layer.iterate());
    const double first = map.layer.variation();
    while (map.layer.has_next_iteration()) ASSERT_TRUE(map.layer.iterate());
    EXPECT_LT(map.layer.variation(), 0.8 * first);
    map.check();
}

TEST(DotLayer, PushesNeighboursApart) {
    TwoSquares map;
    ASSERT_TRUE(map.layer.start());
    const double before = map.layer.least_distance();
    for (int round = 0; round < 20; ++round) map.layer.push_apart(0.8, 0.5, {});
    map.layer.restore();
    EXPECT_GT(map.layer.least_distance(), before + 0.2);
    map.check();
}

TEST(DotLayer, CollectsTheDotsByFeature) {
    TwoSquares map;
    ASSERT_TRUE(map.layer.start());
    const ClassDots dots = map.layer.collect();
    EXPECT_EQ(dots.dots.points.size(), 360U);
    EXPECT_TRUE(std::ranges::is_sorted(dots.feature_of));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/confine.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;

MapFeature feature(const test::Parts& parts, std::vector<std::size_t> dots) {
    return {Domain::repair(parts).value().domain, std::move(dots)};
}

TEST(Confine, KeepsTheIntersection) {
    std::vector<MapFeature> features = {feature({{box(0, 0, 2, 2), {}}}, {3, 4}),
                                        feature({{box(2, 0, 2, 2), {}}}, {1, 0})};
    const Domain kept = Domain::repair({{box(1, 0.5, 2, 1), {box(1.25, 0.75, 0.5, 0.5)}}}).value().domain;
    const auto lost = confine(features, kept);
    ASSERT_TRUE(lost) << lost.error().message;
    EXPECT_TRUE(lost->empty());
    EXPECT_NEAR(features[0].area.area(), 0.75, 1e-12);
    EXPECT_NEAR(features[1].area.area(), 1, 1e-12);
    EXPECT_EQ(features[0].area.bounds().max, (Point{2, 2}));
    EXPECT_EQ(features[0].dots, (std::vector<std::size_t>{3, 4}));
}

TEST(Confine, KeepsFeaturesInside) {
    std::vector<MapFeature> features = {feature({{box(1, 1, 1, 1), {}}}, {5})};
    ASSERT_TRUE(confine(features, Domain::repair({{box(0, 0, 3, 3), {}}}).value().domain));
    EXPECT_EQ(features[0].area.corner_count(), 4U);
    EXPECT_EQ(features[0].area.area(), 1);
}

TEST(Confine, ReportsFeaturesThatLoseTheirDots) {
    std::vector<MapFeature> features = {feature({{box(0, 0, 1, 1), {}}}, {0}), feature({{box(2, 0, 1, 1), {}}}, {2, 1}),
                                        feature({{box(4, 0, 1, 1), {}}}, {7})};
    const auto lost = confine(features, Domain::repair({{box(4.5, 0, 9, 9), {}}}).value().domain);
    ASSERT_TRUE(lost) << lost.error().message;
    EXPECT_EQ(*lost, (std::vector<std::uint32_t>{1}));
    EXPECT_EQ(dots_of(features[1]), 0U);
    EXPECT_EQ(features[1].dots.size(), 2U);
    EXPECT_EQ(dots_of(features[2]), 7U);
}

}  // namespace
}  // namespace ccdt

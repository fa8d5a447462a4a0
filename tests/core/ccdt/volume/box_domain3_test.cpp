// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/box_domain3.h"

#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

constexpr Point3 kSides{1, 0.5, 0.25};
constexpr Box3 kWindow{{-2, -1, -0.5}, {3, 1.5, 0.75}};  // five times as wide as the domain

TEST(BoxDomain3, HasCopiesOfUniformDensity) {
    for (const bool periodic : {false, true}) {
        std::size_t copies = 0, originals = 0;
        BoxDomain3{kSides, periodic}.for_copies({0.3, 0.1, 0.2}, kWindow, [&](Point3 p, bool is_original) {
            ++copies;
            if (!is_original) return;
            ++originals;
            EXPECT_EQ(p, (Point3{0.3, 0.1, 0.2}));
        });
        EXPECT_EQ(copies, 125u) << periodic;
        EXPECT_EQ(originals, 1u) << periodic;
    }
}

TEST(BoxDomain3, MapsCopiesBackToThePoint) {
    const Point3 p{0.3, 0.1, 0.2};
    for (const bool periodic : {false, true}) {
        const BoxDomain3 domain{kSides, periodic};
        const Box3 window{Point3{} - 0.9 * kSides, 1.9 * kSides};
        domain.for_copies(p, window, [&](Point3 copy, bool) {
            EXPECT_LT(length(domain.inside(copy) - p), 1e-15) << copy.x << ' ' << copy.y << ' ' << copy.z;
        });
    }
}

TEST(BoxDomain3, LimitsTheCopiesOfThinDomains) {
    for (const bool periodic : {false, true}) {
        std::size_t copies = 0;
        BoxDomain3{{1, 1, 1e-4}, periodic}.for_copies({0.5, 0.5, 3e-5}, 0.25, [&](Point3, bool) { ++copies; });
        EXPECT_EQ(copies, 61u) << periodic;
    }
}

TEST(BoxDomain3, OmitsTheOriginalOutsideTheWindow) {
    std::vector<Point3> found;
    BoxDomain3{kSides, true}.for_copies({0.9, 0.1, 0.1}, {{-0.2, 0, 0}, {0.2, 0.2, 0.2}},
                                        [&](Point3 p, bool is_original) {
                                            EXPECT_FALSE(is_original);
                                            found.push_back(p);
                                        });
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].x, -0.1, 1e-15);
}

TEST(BoxDomain3, KeepsPointsStrictlyInsideABox) {
    const BoxDomain3 box{kSides, false};
    for (const double v : {-5.0, 0.0, 0.25, 7.0}) {
        const Point3 p = box.inside({v, v, v});
        EXPECT_TRUE(p.x > 0 && p.x < 1 && p.y > 0 && p.y < 0.5 && p.z > 0 && p.z < 0.25) << v;
    }
    EXPECT_EQ((BoxDomain3{kSides, true}.inside({1, 0.5, -0.25})), Point3{});
}

}  // namespace
}  // namespace ccdt

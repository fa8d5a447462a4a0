// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/near_push.h"

#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

/// Pushes two sites of a domain in which the densest packing of 1000 sites has neighbours at a distance of 0.112.
double push(const BoxDomain3& domain, std::vector<Point3>& sites, std::size_t free) {
    const VolumeSpacing spacing(domain, VoxelDensity::uniform(), 1000, inline_executor());
    return push_apart(domain, spacing, sites, free, 1, 0.5, inline_executor(), {});
}

constexpr double kDensest = 0.1 * VolumeSpacing::kDensest;
constexpr BoxDomain3 kBox{}, kTorus{{1, 1, 1}, true};

TEST(NearPush, MovesTwoSitesToTheReach) {
    std::vector<Point3> sites{{0.5, 0.5, 0.5}, {0.55, 0.5, 0.5}};
    EXPECT_NEAR(push(kBox, sites, 2), 0.05 / kDensest, 1e-12);
    EXPECT_NEAR(sites[0].x, 0.525 - kDensest / 2, 1e-12);
    EXPECT_NEAR(sites[1].x, 0.525 + kDensest / 2, 1e-12);
    EXPECT_NEAR(push(kBox, sites, 2), 1, 1e-9);
}

TEST(NearPush, MovesTheFreeSiteOnly) {
    std::vector<Point3> sites{{0.5, 0.5, 0.5}, {0.5, 0.57, 0.5}};
    push(kBox, sites, 1);
    EXPECT_NEAR(sites[0].y, 0.57 - kDensest, 1e-12);
    EXPECT_EQ(sites[1], (Point3{0.5, 0.57, 0.5}));
}

TEST(NearPush, ReachesAcrossTheSeamOfATorus) {
    std::vector<Point3> sites{{0.5, 0.5, 0.01}, {0.5, 0.5, 0.97}};
    push(kTorus, sites, 2);
    EXPECT_NEAR(1 + sites[0].z - sites[1].z, kDensest, 1e-12);
}

TEST(NearPush, MovesSitesOffTheFacesOfABox) {
    std::vector<Point3> sites{{0.5, 0.5, 0.01}};
    for (int i = 0; i < 10; ++i) push(kBox, sites, 1);
    EXPECT_NEAR(2 * sites[0].z, 0.8165 * kDensest, 1e-4);
}

TEST(NearPush, SeparatesCoincidentSites) {
    std::vector<Point3> sites(3, {0.5, 0.5, 0.5});
    EXPECT_LT(push(kBox, sites, 2), 1e-6);
    for (int i = 0; i < 20; ++i) push(kBox, sites, 2);
    EXPECT_NEAR(push(kBox, sites, 2), 1, 1e-2);
    EXPECT_EQ(sites[2], (Point3{0.5, 0.5, 0.5}));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_start.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/volume/box_domain3.h"

namespace ccdt {
namespace {

/// Draws sites in the unit cube, half of whose mass is on either side of x = 1/2. Returns the number of sites with
/// x < 1/2.
std::ptrdiff_t sites_below(std::size_t sites, const std::vector<Point3>& fixed) {
    const VoxelDensity uniform = VoxelDensity::uniform();
    const std::vector<Point3> drawn =
        draw_start(BoxDomain3{}, uniform, uniform, VoxelZones(uniform, false, 1000), sites, fixed, 1, {});
    EXPECT_EQ(drawn.size(), sites + fixed.size());
    EXPECT_TRUE(std::ranges::equal(std::span(drawn).last(fixed.size()), fixed));
    return std::ranges::count_if(std::span(drawn).first(sites), [](Point3 p) { return p.x < 0.5; });
}

TEST(VolumeStart, CountsFixedPointsAsSites) {
    EXPECT_EQ(sites_below(1000, {}), 500);
    EXPECT_EQ(sites_below(600, std::vector<Point3>(400, {0.2, 0.3, 0.4})), 100);
    // The fixed points take more than their half, so all sites are in the other half.
    EXPECT_EQ(sites_below(300, std::vector<Point3>(700, {0.2, 0.3, 0.4})), 0);
    EXPECT_EQ(sites_below(300, std::vector<Point3>(700, {0.7, 0.3, 0.4})), 300);
}

}  // namespace
}  // namespace ccdt

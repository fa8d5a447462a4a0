// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/zones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

constexpr int kSide = 64;

using Function = std::function<double(double x, double y)>;

/// Finds the zones of a density on kSide x kSide cells.
std::vector<std::uint32_t> zones_of(const Function& density, bool periodic = false, double sites = 1000) {
    const auto grid =
        test::grid_of(kSide, kSide, [&](int i, int j) { return density((i + 0.5) / kSide, (j + 0.5) / kSide); });
    return find_zones(grid, periodic, sites);
}

std::size_t count_of(const std::vector<std::uint32_t>& zones) {
    return zones.empty() ? 1 : std::set(zones.begin(), zones.end()).size();
}

double disc(double x, double y) {
    return std::hypot(x - 0.5, y - 0.5) < 0.3 ? 1 : 0;
}

TEST(Zones, DivideBlocksFromAnyBackground) {
    for (const double low : {0.0, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.5, 0.8}) {
        const auto is_dense = [](double x, double y) {
            return (static_cast<int>(4 * x) + static_cast<int>(4 * y)) % 2 == 0;
        };
        const auto zones = zones_of([&](double x, double y) { return is_dense(x, y) ? 1 : low; });
        EXPECT_EQ(count_of(zones), 16u) << low;
        EXPECT_EQ(std::ranges::count(zones, zones[0]), kSide * kSide / 16) << low;
    }
    EXPECT_EQ(count_of(zones_of([](double x, double y) { return 1 + disc(x - 0.5, y - 0.5) + disc(x + 0.5, y + 0.5); },
                                true)),
              3u)
        << "parts of discs at the seam";
}

TEST(Zones, DivideEachPlateau) {
    constexpr std::array kValues{0.0, 0.01, 0.1, 0.5, 1.0};
    const auto zones = zones_of([&](double x, double) { return kValues[static_cast<std::size_t>(5 * x)]; });
    EXPECT_EQ(count_of(zones), 5u);
}

TEST(Zones, DivideSlopesOfOverlappingValues) {
    EXPECT_EQ(count_of(zones_of([](double x, double y) { return (x < 0.5 ? 1 : 3) * (0.1 + y); })), 2u);
    EXPECT_EQ(count_of(zones_of([](double x, double) { return x < 0.5 ? 2 * x : 0.5; })), 2u);
    EXPECT_EQ(count_of(zones_of([](double x, double y) { return x < 0.5 ? 1 : 0.1 + 0.7 * y; })), 2u);
}

TEST(Zones, IncludeRimsOfAntialiasedShapes) {
    for (const double low : {0.0, 0.1, 0.5}) {
        const auto zones = zones_of([&](double x, double y) {
            return std::lerp(low, 1, std::clamp(kSide * (0.3 - std::hypot(x - 0.5, y - 0.5)) + 0.5, 0.0, 1.0));
        });
        ASSERT_EQ(count_of(zones), 2u) << low;
        EXPECT_NEAR(static_cast<double>(std::ranges::count(zones, zones[kSide * kSide / 2 + kSide / 2])),
                    0.09 * 3.1416 * kSide * kSide, 60)
            << low;
    }
}

TEST(Zones, IgnoreNoiseOnPlateaus) {
    Random random(1, 0);
    EXPECT_EQ(
        count_of(zones_of([&](double x, double y) { return (0.1 + disc(x, y)) * (0.8 + 0.4 * random.uniform()); })),
        2u);
}

TEST(Zones, AreOneWithoutResolvedSteps) {
    EXPECT_TRUE(zones_of([](double, double) { return 1; }).empty());
    EXPECT_TRUE(zones_of([](double x, double) { return x; }).empty()) << "ramp";
    EXPECT_TRUE(zones_of([](double x, double) { return std::max(0.0, x - 0.3); }).empty()) << "ramp from zero";
    EXPECT_TRUE(zones_of([](double x, double) { return std::min(2 * x, 1.0); }).empty()) << "ramp to a plateau";
    EXPECT_TRUE(zones_of([](double x, double y) { return std::exp(-8 * std::hypot(x, y)); }, false, 100).empty());
    EXPECT_TRUE(zones_of([](double x, double y) { return 1.01 + std::sin(20 * x) * std::sin(20 * y); }).empty());
    EXPECT_FALSE(zones_of(disc).empty());
    EXPECT_TRUE(zones_of(disc, false, 3).empty()) << "few sites";
}

TEST(Zones, AreCellsThatHoldSeveralSites) {
    const auto grid = [](double sites) {
        return find_zones(test::grid_of(4, 1, [](int i, int) { return 1.0 + i; }), false, sites);
    };
    EXPECT_EQ(count_of(grid(1000)), 4u);
    EXPECT_EQ(count_of(grid(4)), 1u);
}

TEST(Zones, DivideBlocksInSpace) {
    constexpr std::size_t kVoxels = 12;
    std::vector<float> values;
    for (std::size_t i = 0; i < kVoxels * kVoxels * kVoxels; ++i)
        values.push_back((i % kVoxels / 3 + i / kVoxels % kVoxels / 3 + i / kVoxels / kVoxels / 3) % 2 == 0 ? 1
                                                                                                            : 0.01F);
    const auto zones = find_zones({kVoxels, kVoxels, kVoxels}, values, false, 1000);
    EXPECT_EQ(count_of(zones), 64u);
    EXPECT_EQ(std::ranges::count(zones, zones[0]), 27);
    EXPECT_TRUE(find_zones({kVoxels, kVoxels, kVoxels}, values, false, 60).empty()) << "few sites";
}

TEST(Zones, JoinLayersOfATorus) {
    std::vector<float> values;
    for (int layer = 0; layer < 8; ++layer) values.insert(values.end(), 16, layer == 3 || layer == 4 ? 1.0F : 0.1F);
    EXPECT_EQ(count_of(find_zones({4, 4, 8}, values, true, 20)), 2u);
    EXPECT_EQ(count_of(find_zones({4, 4, 8}, values, false, 20)), 3u);
}

TEST(Zones, FormClassesOfAboutTheSameDensity) {
    using Classes = std::vector<std::vector<std::uint32_t>>;
    EXPECT_EQ(group_into_classes(std::vector{2.0, 0.0, 1.1, 1.0, 1.3, 2.0}), (Classes{{1}, {3, 2, 4}, {0, 5}}));
    std::vector<double> doubling{1};
    while (doubling.size() < 40) doubling.push_back(2 * doubling.back());
    EXPECT_EQ(group_into_classes(doubling).size(), 16u);
    EXPECT_EQ(group_into_classes(doubling).back().size(), 25u);
}

}  // namespace
}  // namespace ccdt

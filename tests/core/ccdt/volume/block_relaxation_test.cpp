// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/block_relaxation.h"

#include <gtest/gtest.h>

#include <stop_token>
#include <vector>

#include "core/base/random.h"
#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

constexpr std::size_t kSites = 2'000;

std::vector<Point3> random_sites(const BoxDomain3& domain, std::size_t count) {
    Random random(3, 0);
    std::vector<Point3> sites(count);
    for (Point3& site : sites) {
        site = {random.uniform() * domain.sides.x, random.uniform() * domain.sides.y,
                random.uniform() * domain.sides.z};
    }
    return sites;
}

/// A relaxation with uniform density, and the spacing that it refers to.
struct Uniform {
    explicit Uniform(const BoxDomain3& domain, std::size_t sites, Executor& executor = inline_executor())
        : spacing(domain, density, sites, executor), relaxation(domain, density, spacing, executor) {}
    Uniform(const Uniform&) = delete;
    Uniform& operator=(const Uniform&) = delete;

    VoxelDensity density = VoxelDensity::uniform();
    VolumeSpacing spacing;
    BlockRelaxation<BoxDomain3> relaxation;
};

TEST(BlockRelaxation, EqualisesCapacities) {
    for (const bool periodic : {false, true}) {
        const BoxDomain3 domain{{2, 1, 1}, periodic};
        std::vector<Point3> sites = random_sites(domain, kSites);
        Uniform uniform(domain, kSites);
        const double before = uniform.relaxation.relax(sites, kSites, 5, {});
        double after = before;
        for (int i = 0; i < 4; ++i) after = uniform.relaxation.relax(sites, kSites, 5, {});
        EXPECT_GT(before, 0.8) << "as of random sites";
        EXPECT_LT(after, 0.45 * before);
        for (const Point3& site : sites) {
            EXPECT_TRUE(site.x >= 0 && site.x <= 2 && site.y >= 0 && site.y <= 1 && site.z >= 0 && site.z <= 1);
        }
    }
}

TEST(BlockRelaxation, MovesFreeSitesOnly) {
    const BoxDomain3 domain{};
    std::vector<Point3> sites = random_sites(domain, 500);
    const std::vector<Point3> before = sites;
    Uniform(domain, 500).relaxation.relax(sites, 400, 3, {});
    std::size_t moved = 0;
    for (std::size_t i = 0; i < 400; ++i) moved += sites[i] == before[i] ? 0 : 1;
    EXPECT_GT(moved, 390U);
    for (std::size_t i = 400; i < 500; ++i) EXPECT_EQ(sites[i], before[i]);
}

TEST(BlockRelaxation, DoesNotDependOnThreads) {
    constexpr std::size_t kBlocks = 25'000;  // sites of three blocks
    const BoxDomain3 domain{{1, 1, 1}, true};
    std::vector<Point3> one = random_sites(domain, kBlocks), three = one;
    ThreadExecutor threads(3);
    const double variation = Uniform(domain, kBlocks).relaxation.relax(one, kBlocks, 1, {});
    EXPECT_EQ(Uniform(domain, kBlocks, threads).relaxation.relax(three, kBlocks, 1, {}), variation);
    EXPECT_EQ(one, three);
}

TEST(BlockRelaxation, LeavesSitesAfterAStop) {
    const BoxDomain3 domain{};
    std::vector<Point3> sites = random_sites(domain, 500);
    const std::vector<Point3> before = sites;
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(Uniform(domain, 500).relaxation.relax(sites, 500, 3, stop.get_token()), 0);
    EXPECT_EQ(sites, before);
}

}  // namespace
}  // namespace ccdt

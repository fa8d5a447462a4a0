// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/descriptor_plan.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

Config config_of(std::size_t workers) {
    Config config;
    config.workers = workers;
    return config;
}

std::size_t connections(const Capacity::Limits& limits) {
    return limits.connections + limits.reserve + limits.streams + limits.refused;
}

TEST(DescriptorPlan, KeepsTheConfiguredLimitsIfTheyFit) {
    const Config config = config_of(2);
    const auto plan = share_descriptors(config, wanted_descriptors(config));
    ASSERT_TRUE(plan);
    EXPECT_TRUE(plan->fits());
    EXPECT_EQ(plan->capacity.connections, config.capacity.connections);
    EXPECT_EQ(plan->capacity.streams, config.capacity.streams);
    EXPECT_GT(wanted_descriptors(config), connections(config.capacity));
}

TEST(DescriptorPlan, ReducesAllConnectionLimitsIfFewDescriptorsAreAllowed) {
    const Config config = config_of(2);
    for (const std::size_t allowed : {100u, 128u, 256u, 1024u}) {
        const auto plan = share_descriptors(config, allowed);
        ASSERT_TRUE(plan) << allowed;
        EXPECT_FALSE(plan->fits());
        EXPECT_GE(plan->capacity.connections, 16u);
        EXPECT_GE(plan->capacity.reserve, 8u);
        EXPECT_LE(connections(plan->capacity) + 32 + 20, allowed);
        EXPECT_GE(connections(plan->capacity) + 32 + 20 + 4, allowed) << "no descriptor may be left unused";
        EXPECT_EQ(plan->capacity.per_address, config.capacity.per_address);
        EXPECT_NE(describe(*plan).find("ulimit -n) is " + std::to_string(allowed)), std::string::npos);
    }
}

TEST(DescriptorPlan, RefusesALimitThatIsTooLow) {
    const auto plan = share_descriptors(config_of(2), 64);
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().message, "the limit of open files (ulimit -n) is 64: at least 84 are needed");
    EXPECT_TRUE(share_descriptors(config_of(2), 84));
    EXPECT_FALSE(share_descriptors(config_of(2), 83));
    EXPECT_FALSE(share_descriptors(config_of(32), 128)) << "workers need descriptors, too";
}

TEST(DescriptorPlan, NeedsOnlyTheConfiguredConnections) {
    Config config = config_of(2);
    config.capacity.connections = 4;
    config.capacity.reserve = 2;
    config.capacity.streams = 0;
    config.capacity.refused = 2;
    EXPECT_EQ(wanted_descriptors(config), 60u);
    EXPECT_TRUE(share_descriptors(config, 60)->fits());
    EXPECT_FALSE(share_descriptors(config, 59));
}

}  // namespace
}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/memory_plan.h"

#include <gtest/gtest.h>

#include <string>

#include "server/config/memory_shares.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

TEST(MemoryPlan, CapsTheSharesOfALargeMemory) {
    const auto shares = share_memory(64'000 * kMebibyte, 64 * kMebibyte);
    EXPECT_EQ(shares.transfers, 256 * kMebibyte);
    EXPECT_EQ(shares.cache, 64 * kMebibyte);
    EXPECT_EQ(shares.jobs, 256 * kMebibyte);
    EXPECT_EQ(share_memory(64'000 * kMebibyte, 100 * kMebibyte).transfers, 400 * kMebibyte) << "four bodies";
}

TEST(MemoryPlan, DividesASmallMemoryByFixedShares) {
    const auto shares = share_memory(352 * kMebibyte, 64 * kMebibyte);
    EXPECT_EQ(shares.transfers, 40 * kMebibyte);
    EXPECT_EQ(shares.cache, 10 * kMebibyte);
    EXPECT_EQ(shares.jobs, 10 * kMebibyte);
    EXPECT_EQ(share_memory(100 * kMebibyte, 64 * kMebibyte).transfers, 0U);
}

/// Returns the configuration with default flags.
Config default_config(std::size_t memory, std::size_t cores) {
    Config config;
    config.memory = memory;
    config.workers = default_workers(cores, memory);
    const auto shares = share_memory(memory, config.max_body);
    config.capacity.bytes = shares.transfers;
    config.cache = shares.cache;
    config.jobs.bytes = shares.jobs;
    return config;
}

TEST(MemoryPlan, DefaultsFitIntoContainersOf512MiB) {
    constexpr std::size_t kResident = 24 * kMebibyte;  // at the start of the server; 17 MiB on amd64
    EXPECT_EQ(default_memory(4'096 * kMebibyte), 2'048 * kMebibyte);
    for (std::size_t container = 512; container < 10'000; container += 16) {
        for (const std::size_t cores : {1, 2, 4, 8, 64, 256}) {
            const auto config = default_config(default_memory(container * kMebibyte), cores);
            EXPECT_TRUE(memory_to_compute_with(config, kResident)) << container << " MiB, " << cores << " cores";
        }
    }
}

TEST(MemoryPlan, NamesAMemoryThatSuffices) {
    constexpr std::size_t kResident = 24 * kMebibyte;
    for (std::size_t memory = 1; memory < 320; memory += 7) {
        for (const std::size_t cores : {1, 4, 256}) {
            const auto refused = memory_to_compute_with(default_config(memory * kMebibyte, cores), kResident);
            if (refused) continue;
            const std::string& message = refused.error().message;
            const std::size_t enough = std::stoul(message.substr(message.find(": ") + 2));
            EXPECT_TRUE(memory_to_compute_with(default_config(enough * kMebibyte, cores), kResident)) << message;
            EXPECT_LE(enough, 512U) << message;
        }
    }
}

Config config_of(std::size_t memory) {
    Config config;
    config.memory = memory;
    config.workers = 2;
    config.capacity.bytes = 256 * kMebibyte;
    config.cache = 64 * kMebibyte;
    config.jobs.bytes = 100 * kMebibyte;
    return config;
}

TEST(MemoryPlan, AssignsTheRestToComputations) {
    Config config = config_of(2'000 * kMebibyte);
    const auto in_memory = memory_to_compute_with(config, 100 * kMebibyte);
    ASSERT_TRUE(in_memory);
    EXPECT_EQ(in_memory->total, (2'000 - 100 - 160 - 6 * 4 - 256 - 64 - 100) * kMebibyte);
    EXPECT_EQ(in_memory->jobs, in_memory->total / 4 * 3);
    EXPECT_EQ(in_memory->requests, in_memory->total / 4);
    config.data_dir = "/jobs";
    EXPECT_EQ(memory_to_compute_with(config, 100 * kMebibyte)->total, in_memory->total + 100 * kMebibyte);
    config.data_dir.clear();
    config.redis.emplace();
    EXPECT_EQ(memory_to_compute_with(config, 100 * kMebibyte)->total, in_memory->total + 100 * kMebibyte);
}

TEST(MemoryPlan, LeavesMemoryForComputations) {
    const std::size_t taken = (100 + 160 + 6 * 4 + 256 + 64 + 100) * kMebibyte;
    EXPECT_TRUE(memory_to_compute_with(config_of(taken + 48 * kMebibyte), 100 * kMebibyte));
    const auto refused = memory_to_compute_with(config_of(taken + 47 * kMebibyte), 100 * kMebibyte);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Malformed);
}

}  // namespace
}  // namespace ccdt::server

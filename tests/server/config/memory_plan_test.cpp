// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/memory_plan.h"

#include <gtest/gtest.h>

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
    const auto shares = share_memory(160 * kMebibyte, 64 * kMebibyte);
    EXPECT_EQ(shares.transfers, 40 * kMebibyte);
    EXPECT_EQ(shares.cache, 10 * kMebibyte);
    EXPECT_EQ(shares.jobs, 10 * kMebibyte);
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

TEST(MemoryPlan, ReportsHowMuchMemoryIsNeeded) {
    const std::size_t taken = (100 + 160 + 6 * 4 + 256 + 64 + 100) * kMebibyte;
    EXPECT_TRUE(memory_to_compute_with(config_of(taken + 192 * kMebibyte), 100 * kMebibyte));
    const auto refused = memory_to_compute_with(config_of(taken + 191 * kMebibyte), 100 * kMebibyte);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Malformed);
    EXPECT_NE(refused.error().message.find(std::to_string(taken / kMebibyte + 192) + " MiB are needed (--memory)"),
              std::string::npos);
}

}  // namespace
}  // namespace ccdt::server

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/site_blocks.h"

#include <initializer_list>
#include <utility>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

constexpr std::size_t kCounts[] = {0, 1, 2047, 2048, 4095, 4096, 5000, 16'384, 100'003, 1'048'576, 20'000'000};

TEST(SiteBlocks, DivideAllSitesInOrder) {
    for (const std::size_t sites : kCounts) {
        SCOPED_TRACE(sites);
        const SiteBlocks blocks(sites);
        const std::size_t count = blocks.count(0);
        EXPECT_EQ(blocks.begin(0), 0u);
        EXPECT_EQ(blocks.begin(count), sites);
        for (std::uint32_t block = 0; block < count; ++block) {
            const std::uint32_t begin = blocks.begin(block), end = blocks.begin(block + 1);
            if (sites < 2 * SiteBlocks::kMinSites) continue;
            ASSERT_GE(end - begin, SiteBlocks::kMinSites - 1) << block;
            ASSERT_LE(end - begin, 2 * SiteBlocks::kMinSites) << block;
            ASSERT_EQ(blocks.of(begin), block);
            ASSERT_EQ(blocks.of(end - 1), block);
        }
    }
}

TEST(SiteBlocks, EndInOneBlockOfAllSites) {
    for (const std::size_t sites : kCounts) {
        SCOPED_TRACE(sites);
        const SiteBlocks blocks(sites);
        for (int level = 0; level < blocks.last_level(); ++level) {
            EXPECT_GT(blocks.count(level), 1u);
            EXPECT_GE(blocks.count(level), blocks.count(level + 1));
            EXPECT_LE(blocks.count(level), 4 * blocks.count(level + 1));
        }
        EXPECT_EQ(blocks.count(blocks.last_level()), 1u);
    }
}

TEST(SiteBlocks, FindTheSmallestBlockAroundVertices) {
    const SiteBlocks blocks(131'072);  // 64 blocks of 2,048
    ASSERT_EQ(blocks.levels(), 4);
    const auto around = [&](std::initializer_list<std::uint32_t> vertices) {
        const auto block = blocks.around(vertices);
        return std::pair{block.level, block.number};
    };
    EXPECT_EQ(around({5000, 5001}), std::pair(0, 2u));
    EXPECT_EQ(around({8191, 0, 4096}), std::pair(1, 0u));
    EXPECT_EQ(around({8191, 8192}), std::pair(2, 0u));
    EXPECT_EQ(around({40'000, 64'000}), std::pair(2, 1u));
    EXPECT_EQ(around({65'535, 65'536}), std::pair(3, 0u));
    EXPECT_EQ(around({0, 131'072}), std::pair(3, 0u)) << "no site";
    EXPECT_EQ(around({131'072, 131'073}), std::pair(3, 0u)) << "no sites";
}

}  // namespace
}  // namespace ccdt

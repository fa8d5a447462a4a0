// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pmtiles.h"

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt::api {
namespace {

/// The numbers are examples of the specification of PMTiles.
TEST(TileNumber, FollowsHilbertsCurve) {
    EXPECT_EQ(tile_number(0, 0, 0), 0U);
    EXPECT_EQ(tile_number(1, 0, 0), 1U);
    EXPECT_EQ(tile_number(1, 0, 1), 2U);
    EXPECT_EQ(tile_number(1, 1, 1), 3U);
    EXPECT_EQ(tile_number(1, 1, 0), 4U);
    EXPECT_EQ(tile_number(2, 0, 0), 5U);
    EXPECT_EQ(tile_number(12, 3423, 1763), 19078479U);
}

TEST(TileDirectory, IsReadAsWritten) {
    const std::vector<TileEntry> entries = {{3, 0, 10, 1}, {4, 10, 5, 3}, {9, 100, 7, 0}, {1'000'000'007, 20, 1, 1}};
    const auto read = read_directory(write_directory(entries));
    ASSERT_TRUE(read);
    ASSERT_EQ(read->size(), entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
        EXPECT_EQ((*read)[i].id, entries[i].id);
        EXPECT_EQ((*read)[i].offset, entries[i].offset);
        EXPECT_EQ((*read)[i].length, entries[i].length);
        EXPECT_EQ((*read)[i].run, entries[i].run);
    }
    const auto found = [&](std::uint64_t tile) {
        const TileEntry* entry = find_entry(*read, tile);
        return entry == nullptr ? 0 : entry->id;
    };
    EXPECT_EQ(found(2), 0U);
    EXPECT_EQ(found(3), 3U);
    EXPECT_EQ(found(6), 4U);
    EXPECT_EQ(found(7), 0U);
    EXPECT_EQ(found(8), 0U);
    EXPECT_EQ(found(50), 9U) << "in the directory of later tiles";
    EXPECT_EQ(find_entry({}, 1), nullptr);
}

TEST(TileDirectory, OfDamagedBytesIsNone) {
    EXPECT_FALSE(read_directory("no gzip"));
    EXPECT_FALSE(read_directory(gzipped(std::string("\5\1", 2)))) << "too short";
    EXPECT_FALSE(read_directory(gzipped("\xff\xff\xff\xff\x7f"))) << "too many entries";
    const std::string whole = write_directory(std::vector<TileEntry>{{3, 0, 10, 1}});
    EXPECT_FALSE(read_directory(whole.substr(0, whole.size() - 9)));
}

TEST(TileArchive, IsReadAsWritten) {
    TileArchive archive;
    archive.leaves = {1'000, 20};
    archive.tiles = {5'000'000'000, 70};
    archive.max_zoom = 14;
    archive.min = {-12.5, -80};
    archive.max = {170.25, 7};
    const std::string bytes = write_header(archive);
    EXPECT_EQ(bytes.size(), TileArchive::kHeader);
    const auto read = read_header(bytes + "rest");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->leaves.length, 20U);
    EXPECT_EQ(read->tiles.offset, 5'000'000'000U);
    EXPECT_EQ(read->max_zoom, 14);
    EXPECT_EQ(read->min, archive.min);
    EXPECT_EQ(read->max, archive.max);
    EXPECT_FALSE(read_header(bytes.substr(1)));
    EXPECT_FALSE(read_header("PMTiles\3"));
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/coverage.h"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

std::vector<BorderEdge> closed(const std::vector<Point>& ring, double weight = 1) {
    std::vector<BorderEdge> border;
    for (std::size_t i = 0; i < ring.size(); ++i) border.push_back({ring[i], ring[(i + 1) % ring.size()], weight});
    return border;
}

/// Returns the borders of a triangle of area 1/2, and of a square with a hole above it, with twice the weight.
std::vector<BorderEdge> areas() {
    auto border = closed({{1, 0}, {2, 0}, {2, 1}});
    for (const auto& ring : {closed({{4, 2}, {7, 2}, {7, 5}, {4, 5}}, 2), closed({{5, 3}, {5, 4}, {6, 4}, {6, 3}}, 2)})
        border.insert(border.end(), ring.begin(), ring.end());
    return border;
}

TEST(Coverage, IsTheCoveredShareOfEachCell) {
    const auto share = coverage(areas(), {8, 6}, 8, 6);
    ASSERT_EQ(share.size(), 48u);
    EXPECT_NEAR(share[1], 0.5, 1e-12);
    EXPECT_NEAR(share[2 * 8 + 4], 2, 1e-12);
    EXPECT_NEAR(share[3 * 8 + 5], 0, 1e-12);
    EXPECT_NEAR(share[3 * 8 + 6], 2, 1e-12);
    EXPECT_NEAR(std::accumulate(share.begin(), share.end(), 0.0), 0.5 + 2 * 8, 1e-12);
}

TEST(Coverage, ListsOnlyCellsBetweenBorders) {
    const CrossedCells cells = crossed_coverage(areas(), {8, 6}, 16, 12);
    ASSERT_EQ(cells.rows.size(), 12u);
    EXPECT_EQ(cells.rows[0].end - cells.rows[0].first, 3u) << "from 1 to 2, and the column that begins at 2";
    for (const std::size_t row : {3, 11}) EXPECT_EQ(cells.rows[row].first, cells.rows[row].end) << row;
    for (const std::size_t row : {4, 5, 6, 7, 8, 9}) {
        EXPECT_EQ(cells.rows[row].first, 8u) << row;
        EXPECT_EQ(cells.rows[row].end, 15u) << row << ": to 7, and the column that begins there";
    }
    const auto all = coverage(areas(), {8, 6}, 16, 12);
    EXPECT_EQ(std::accumulate(all.begin(), all.end(), 0.0),
              std::accumulate(cells.values.begin(), cells.values.end(), 0.0));
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/spot_field.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr Box kBox{{0, 0}, {30, 20}};
constexpr CellGrid kCells{600, 400};

std::vector<Point> sites(std::size_t count) {
    Random random(5, 0);
    std::vector<Point> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back({30 * random.uniform(), 20 * random.uniform()});
    return points;
}

TEST(SpotField, CoversEachShareOfThePicture) {
    const auto all = sites(300);
    for (const std::size_t count : {20, 300}) {
        const SpotTriangles triangles(std::span<const Point>(all).first(count), kBox);
        const auto values = SpotField(triangles, kCells).values();
        for (const float share : {0.1F, 0.3F, 0.5F, 0.8F}) {
            const auto covered = std::ranges::count_if(values, [&](float value) { return value > 1 - share; });
            EXPECT_NEAR(static_cast<double>(covered) / static_cast<double>(values.size()), share, 0.006)
                << count << " sites";
        }
    }
}

TEST(SpotField, IsLargestAtSites) {
    const auto all = sites(50);
    const SpotTriangles triangles(all, kBox);
    const auto values = SpotField(triangles, kCells).values();
    for (const Point& p : all) {
        const auto x = static_cast<std::size_t>(p.x * 20), y = static_cast<std::size_t>(p.y * 20);
        EXPECT_GT(values[y * 600 + x], 0.9F);
    }
}

TEST(SpotField, PaintsTheSameRowsAloneAndTogether) {
    const SpotTriangles triangles(sites(200), kBox);
    const SpotField field(triangles, kCells);
    const auto all = field.values();
    for (const auto& [first, end] : {std::pair(0, 1), {30, 35}, {63, 130}, {399, 400}}) {
        std::vector<float> rows(static_cast<std::size_t>(end - first) * 600);
        field.paint(first, end, rows);
        EXPECT_TRUE(
            std::ranges::equal(rows, std::span(all).subspan(static_cast<std::size_t>(first) * 600, rows.size())));
    }
}

}  // namespace
}  // namespace ccdt

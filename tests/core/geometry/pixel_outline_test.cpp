// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/pixel_outline.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

/// Parses rows from the top, separated by /; # marks a pixel.
PixelSet pixels_of(std::string_view rows) {
    PixelSet pixels;
    int column = 0;
    for (const char c : rows) {
        if (c == '/') {
            column = 0;
            continue;
        }
        ++column;
        pixels.width = std::max(pixels.width, column);
        pixels.marked.push_back(c == '#');
    }
    pixels.height = static_cast<int>(pixels.marked.size()) / pixels.width;
    return pixels;
}

constexpr std::size_t kMany = 1'000'000;

double signed_area(const Ring& ring) {
    double twice = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return twice / 2;
}

bool is_inside(const Area& area, Point p) {
    bool odd = false;
    for (const Ring& ring : area) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()];
            if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) odd = !odd;
        }
    }
    return odd;
}

TEST(PixelOutline, HasTheCornersOfAPixel) {
    const auto area = outline_of(pixels_of("../#."), {{10, 20}, {14, 24}}, kMany);
    ASSERT_TRUE(area);
    EXPECT_EQ(*area, (Area{{{12, 20}, {12, 22}, {10, 22}, {10, 20}}}));
}

TEST(PixelOutline, KeepsHoles) {
    const auto area = outline_of(pixels_of("####/#..#/####"), {{0, 0}, {4, 3}}, kMany);
    ASSERT_EQ(area->size(), 2U);
    EXPECT_DOUBLE_EQ(signed_area(area->front()), 12);
    EXPECT_DOUBLE_EQ(signed_area(area->back()), -2);
}

TEST(PixelOutline, SeparatesPixelsThatTouchAtACorner) {
    for (const auto* rows : {"#./.#", ".#/#."}) {
        const auto area = outline_of(pixels_of(rows), {{0, 0}, {2, 2}}, kMany);
        ASSERT_EQ(area->size(), 2U) << rows;
        EXPECT_EQ(area->front().size(), 4U);
    }
}

TEST(PixelOutline, MatchesTheBoxExactly) {
    const Box box{{0.1, -0.7}, {1.0 / 3, 1e-3}};
    const auto area = outline_of(pixels_of("###/###/###"), box, kMany);
    ASSERT_EQ(area->size(), 1U);
    EXPECT_EQ(area->front(), (Ring{{box.max.x, box.min.y}, box.max, {box.min.x, box.max.y}, box.min}));
}

TEST(PixelOutline, IsEmptyWithoutMarkedPixels) {
    EXPECT_TRUE(outline_of(pixels_of(".."), {{0, 0}, {2, 1}}, kMany)->empty());
}

TEST(PixelOutline, RespectsTheLimitOnCorners) {
    const PixelSet pixels = pixels_of("#.#/.#.");
    EXPECT_TRUE(outline_of(pixels, {{0, 0}, {3, 2}}, 12));
    EXPECT_FALSE(outline_of(pixels, {{0, 0}, {3, 2}}, 11));
}

TEST(PixelOutline, EnclosesTheMarkedPixels) {
    Random random(7, 0);
    for (int i = 0; i < 50; ++i) {
        PixelSet pixels{1 + static_cast<int>(random.uniform() * 12), 1 + static_cast<int>(random.uniform() * 12), {}};
        for (int cell = 0; cell < pixels.width * pixels.height; ++cell) pixels.marked.push_back(random.uniform() < 0.5);
        const auto area = outline_of(pixels, {{0, 0}, {double(pixels.width), double(pixels.height)}}, kMany);
        ASSERT_TRUE(area);
        for (int y = 0; y < pixels.height; ++y) {
            for (int x = 0; x < pixels.width; ++x) {
                const auto cell = static_cast<std::size_t>((pixels.height - 1 - y) * pixels.width + x);
                EXPECT_EQ(is_inside(*area, {x + 0.5, y + 0.5}), pixels.marked[cell]) << x << ' ' << y;
            }
        }
    }
}

}  // namespace
}  // namespace ccdt

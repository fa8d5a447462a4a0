// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_renderer.h"

#include <gtest/gtest.h>

#include <array>

#include "api/output/svg_drawing.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

using Pixel = std::array<std::uint8_t, 4>;

constexpr Pixel kPaper = {255, 255, 255, 255}, kInk = {0, 0, 0, 255};

TEST(SvgRenderer, DrawsAtScale) {
    SvgDrawing svg(30, 20);
    svg.rectangle({{10, 5}, {20, 10}}, "fill=\"#123456\"");
    const auto file = render_svg(svg.finish(), 2);
    ASSERT_TRUE(file) << file.error().message;
    const auto png = decode_png(*file);
    EXPECT_EQ(png.width, 60);
    EXPECT_EQ(png.height, 40);
    EXPECT_EQ(png.at(0, 0), kPaper);
    EXPECT_EQ(png.at(20, 10), (Pixel{0x12, 0x34, 0x56, 255}));
    EXPECT_EQ(png.at(39, 19), (Pixel{0x12, 0x34, 0x56, 255}));
    EXPECT_EQ(png.at(40, 20), kPaper);
}

TEST(SvgRenderer, DrawsDotsInsideClipOnly) {
    SvgDrawing svg(40, 20);
    const std::array<Point, 2> centres = {Point{10, 10}, Point{30, 10}};
    svg.begin_clip({{0, 0}, {30, 20}});
    svg.dots(centres, 5);
    svg.end_clip();
    const auto png = decode_png(render_svg(svg.finish(), 1).value());
    EXPECT_EQ(png.at(10, 10), kInk);
    EXPECT_EQ(png.at(6, 10), kInk);
    EXPECT_EQ(png.at(4, 10), kPaper);
    EXPECT_EQ(png.at(5, 5), kPaper) << "dots are round";
    EXPECT_EQ(png.at(27, 10), kInk);
    EXPECT_EQ(png.at(32, 10), kPaper) << "outside the clip";
}

TEST(SvgRenderer, FindsItsFont) {
    SvgDrawing svg(40, 20);
    svg.text({5, 15}, Anchor::Start, 14, "M");
    const auto png = decode_png(render_svg(svg.finish(), 1).value());
    const auto dark = std::count_if(png.pixels.begin(), png.pixels.end(), [](Pixel p) { return p[0] < 128; });
    EXPECT_GT(dark, 15);
    EXPECT_LT(dark, 120);
}

TEST(SvgRenderer, IsReproducible) {
    SvgDrawing svg(100, 30);
    svg.text({5, 20}, Anchor::Start, 14.5, "frequency, 3.75");
    const std::string text = svg.finish();
    EXPECT_EQ(render_svg(text, 1.5).value(), render_svg(text, 1.5).value());
}

TEST(SvgRenderer, RejectsInvalidSvg) {
    for (const std::string text : {"", "dots", "<svg", "<html/>"}) {
        const auto file = render_svg(text, 1);
        ASSERT_FALSE(file) << text;
        EXPECT_EQ(file.error().code, ErrorCode::Internal);
    }
}

}  // namespace
}  // namespace ccdt::api

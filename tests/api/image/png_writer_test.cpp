// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/png_writer.h"

#include <gtest/gtest.h>
#include <png.h>

#include "tests/api/files.h"
#include "tests/api/image/rasters.h"

namespace ccdt::api {
namespace {

using Rgba = std::array<std::uint8_t, 4>;

void expect_binary(const Colour& ink, const Colour& ground, Rgba dot, Rgba paper, int colour_type) {
    const auto file = write_png(image_of(binary_raster(), false, ink, ground));
    ASSERT_TRUE(file);
    const DecodedPng png = decode_png(*file);
    EXPECT_EQ(png.bit_depth, 1);
    EXPECT_EQ(png.colour_type, colour_type);
    ASSERT_EQ(png.width, 19);
    ASSERT_EQ(png.height, 5);
    for (int y = 0; y < png.height; ++y) {
        for (int x = 0; x < png.width; ++x) ASSERT_EQ(png.at(x, y), (x + y) % 3 == 0 ? dot : paper) << x << ' ' << y;
    }
}

TEST(PngWriter, WritesBinaryRastersWithOneBit) {
    expect_binary(kBlack, kWhite, {0, 0, 0, 255}, {255, 255, 255, 255}, PNG_COLOR_TYPE_GRAY);
    expect_binary(kWhite, kBlack, {255, 255, 255, 255}, {0, 0, 0, 255}, PNG_COLOR_TYPE_GRAY);
    expect_binary({1, 2, 3}, {250, 240, 230}, {1, 2, 3, 255}, {250, 240, 230, 255}, PNG_COLOR_TYPE_PALETTE);
}

TEST(PngWriter, MakesTheBackgroundTransparent) {
    expect_binary({9, 8, 7}, {.transparent = true}, {9, 8, 7, 255}, {9, 8, 7, 0}, PNG_COLOR_TYPE_PALETTE);
}

TEST(PngWriter, MixesInLinearLight) {
    const auto file = write_png(image_of(grey_raster(1), true));
    const DecodedPng png = decode_png(*file);
    EXPECT_EQ(png.bit_depth, 8);
    EXPECT_EQ(png.colour_type, PNG_COLOR_TYPE_GRAY);
    EXPECT_EQ(png.at(0, 0), (Rgba{255, 255, 255, 255}));
    EXPECT_EQ(png.at(255, 0), (Rgba{0, 0, 0, 255}));
    // Half the light is sRGB 188, not 128.
    EXPECT_NEAR(png.at(128, 0)[0], 187.5, 1);
}

TEST(PngWriter, MixesColoursInAPalette) {
    const auto file = write_png(image_of(grey_raster(1), true, {255, 0, 0}, {0, 0, 255}));
    const DecodedPng png = decode_png(*file);
    EXPECT_EQ(png.colour_type, PNG_COLOR_TYPE_PALETTE);
    EXPECT_EQ(png.at(0, 0), (Rgba{0, 0, 255, 255}));
    EXPECT_EQ(png.at(255, 0), (Rgba{255, 0, 0, 255}));
    EXPECT_NEAR(png.at(128, 0)[0], 188, 1);
    EXPECT_NEAR(png.at(128, 0)[2], 188, 1);
}

TEST(PngWriter, UsesCoverageAsAlphaOnTransparentPaper) {
    const auto file = write_png(image_of(grey_raster(1), true, {9, 8, 7}, {.transparent = true}));
    const DecodedPng png = decode_png(*file);
    for (int x = 0; x < 256; ++x) ASSERT_EQ(png.at(x, 0), (Rgba{9, 8, 7, static_cast<std::uint8_t>(x)}));
}

TEST(PngWriter, WritesSrgbChunks) {
    for (const bool antialias : {false, true}) {
        const auto file = write_png(image_of(binary_raster(), antialias));
        for (const auto* chunk : {"sRGB", "gAMA", "cHRM"}) EXPECT_NE(file->find(chunk), std::string::npos) << chunk;
        EXPECT_EQ(file->find("pHYs"), std::string::npos);
    }
    const std::vector<std::uint16_t> thresholds(4);
    EXPECT_EQ(write_greys(thresholds, 2, 2, 8)->find("sRGB"), std::string::npos);
}

TEST(PngWriter, WritesTheResolution) {
    const std::string file = *write_png(image_of(binary_raster(), false), 19 * 0.0254);  // 1,000 pixels per inch
    const std::size_t at = file.find("pHYs");
    ASSERT_NE(at, std::string::npos);
    // 39,370 pixels per metre, horizontally and vertically, big-endian.
    EXPECT_EQ(file.substr(at + 4, 9), std::string("\0\0\x99\xca\0\0\x99\xca\1", 9));
}

TEST(PngWriter, IsDeterministic) {
    const DotImage image = image_of(binary_raster(), false);
    EXPECT_EQ(*write_png(image), *write_png(image));
}

}  // namespace
}  // namespace ccdt::api

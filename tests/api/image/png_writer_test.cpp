#include "api/image/png_writer.h"

#include <gtest/gtest.h>
#include <png.h>

#include <numeric>

#include "tests/api/files.h"
#include "tests/api/image/rasters.h"

namespace ccdt::api {
namespace {

using Rgba = std::array<std::uint8_t, 4>;

/// Every coverage once.
Raster grey_raster() {
    Raster raster{256, 1, 1, std::vector<std::uint8_t>(256)};
    std::iota(raster.coverage.begin(), raster.coverage.end(), std::uint8_t{0});
    return raster;
}

void expect_binary(const Inks& inks, Rgba dot, Rgba paper, int colour_type) {
    const auto file = write_png(binary_raster(), false, inks);
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

TEST(PngWriter, WritesBinaryRastersAtOneBit) {
    expect_binary({}, {0, 0, 0, 255}, {255, 255, 255, 255}, PNG_COLOR_TYPE_GRAY);
    expect_binary({kWhite, kBlack}, {255, 255, 255, 255}, {0, 0, 0, 255}, PNG_COLOR_TYPE_GRAY);
    expect_binary({{1, 2, 3}, {250, 240, 230}}, {1, 2, 3, 255}, {250, 240, 230, 255}, PNG_COLOR_TYPE_PALETTE);
}

TEST(PngWriter, LeavesATransparentBackgroundOut) {
    expect_binary({{9, 8, 7}, {.transparent = true}}, {9, 8, 7, 255}, {9, 8, 7, 0}, PNG_COLOR_TYPE_PALETTE);
}

TEST(PngWriter, MixesInLinearLight) {
    const auto file = write_png(grey_raster(), true, {});
    const DecodedPng png = decode_png(*file);
    EXPECT_EQ(png.bit_depth, 8);
    EXPECT_EQ(png.colour_type, PNG_COLOR_TYPE_GRAY);
    EXPECT_EQ(png.at(0, 0), (Rgba{255, 255, 255, 255}));
    EXPECT_EQ(png.at(255, 0), (Rgba{0, 0, 0, 255}));
    // Half the light is sRGB 188, not 128.
    EXPECT_NEAR(png.at(128, 0)[0], 187.5, 1);
}

TEST(PngWriter, MixesColoursInAPalette) {
    const auto file = write_png(grey_raster(), true, {{255, 0, 0}, {0, 0, 255}});
    const DecodedPng png = decode_png(*file);
    EXPECT_EQ(png.colour_type, PNG_COLOR_TYPE_PALETTE);
    EXPECT_EQ(png.at(0, 0), (Rgba{0, 0, 255, 255}));
    EXPECT_EQ(png.at(255, 0), (Rgba{255, 0, 0, 255}));
    EXPECT_NEAR(png.at(128, 0)[0], 188, 1);
    EXPECT_NEAR(png.at(128, 0)[2], 188, 1);
}

TEST(PngWriter, UsesCoverageAsAlphaOverNothing) {
    const auto file = write_png(grey_raster(), true, {{9, 8, 7}, {.transparent = true}});
    const DecodedPng png = decode_png(*file);
    for (int x = 0; x < 256; ++x) ASSERT_EQ(png.at(x, 0), (Rgba{9, 8, 7, static_cast<std::uint8_t>(x)}));
}

TEST(PngWriter, WritesTheSameBytesAgain) {
    EXPECT_EQ(*write_png(binary_raster(), false, {}), *write_png(binary_raster(), false, {}));
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tiffio.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "api/image/image_codec.h"
#include "api/image/jpeg_writer.h"
#include "api/image/png_writer.h"
#include "api/image/srgb.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "tests/api/files.h"
#include "tests/api/image/rasters.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kPixels = 1 << 20;

/// Checks that a file shows the same picture as a PNG. WebP rounds greys, as three channels, and the product of light
/// and alpha.
void expect_same(const Result<std::string>& file, const Result<std::string>& png) {
    ASSERT_TRUE(file) << file.error().message;
    const auto read = decode_image(*file, kPixels);
    const auto expected = decode_image(*png, kPixels);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->width, expected->width);
    ASSERT_EQ(read->height, expected->height);
    ASSERT_EQ(read->alpha, expected->alpha);
    for (std::size_t i = 0; i < read->luminance.size(); ++i) {
        const float alpha = read->alpha.empty() ? 1 : read->alpha[i];
        const double tolerance = read->alpha.empty() ? 1e-6 : 0.005;
        ASSERT_NEAR(alpha * read->luminance[i], alpha * expected->luminance[i], tolerance) << i;
    }
}

/// Returns pictures of an ink on each kind of paper, bilevel and antialiased.
std::vector<DotImage> images() {
    std::vector<DotImage> images;
    const std::vector<std::pair<Colour, Colour>> colours = {{kBlack, kWhite},
                                                            {kWhite, kBlack},
                                                            {{1, 2, 3}, {250, 240, 230}},
                                                            {{90, 90, 90}, {200, 200, 200}},
                                                            {{9, 8, 7}, {.transparent = true}}};
    for (const auto& [ink, paper] : colours) {
        images.push_back(image_of(binary_raster(), false, ink, paper));
        images.push_back(image_of(grey_raster(40), true, ink, paper));
    }
    return images;
}

TEST(TiffWriter, EqualsThePng) {
    for (const DotImage& image : images()) expect_same(write_tiff(image), write_png(image));
}

TEST(WebPWriter, EqualsThePng) {
    for (const DotImage& image : images()) expect_same(write_webp(image), write_png(image));
}

TEST(JpegWriter, LooksLikeThePng) {
    for (const DotImage& image : images()) {
        if (image.transparent) continue;
        const auto read = decode_image(*write_jpeg(image, 100), kPixels),
                   expected = decode_image(*write_png(image), kPixels);
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_EQ(read->width, expected->width);
        ASSERT_EQ(read->height, expected->height);
        for (std::size_t i = 0; i < read->luminance.size(); ++i)
            ASSERT_NEAR(read->luminance[i], expected->luminance[i], 0.03) << i;
    }
}

TEST(JpegWriter, KeepsEachColourOfAdjacentPixels) {
    DotImage image{16, 8, false, false, 0, {}, {}};
    for (int i = 0; i < 16 * 8; ++i)
        image.pixels.insert(image.pixels.end(), {255, static_cast<std::uint8_t>(i % 2 * 255), 0});
    const auto read = decode_image(*write_jpeg(image, 100), kPixels);
    // Red has the luminance 0.2126, and yellow 0.9278. With chroma of half the resolution, these would be nearer.
    EXPECT_NEAR(read->luminance[4 * 16 + 4], 0.2126, 0.02);
    EXPECT_NEAR(read->luminance[4 * 16 + 5], 0.9278, 0.02);
}

TEST(JpegWriter, MakesSmallerFilesOfLowerQuality) {
    const DotImage image = image_of(grey_raster(40), true);
    EXPECT_LT(write_jpeg(image, 30)->size(), write_jpeg(image, 90)->size());
}

/// Returns a picture that is 19 pixels wide, with a palette of so many colours or, for 0, true colours.
DotImage colour_image(std::size_t colours, bool transparent) {
    DotImage raster{19, 5, transparent, false, colours, {}, {}};
    for (std::size_t i = 0; i < colours; ++i) {
        const auto shade = static_cast<std::uint8_t>(255 * i / (colours - 1));
        raster.palette[i] = {shade, static_cast<std::uint8_t>(255 - shade), 77,
                             static_cast<std::uint8_t>(transparent && i == 0 ? 0 : 255)};
    }
    const std::size_t size = std::size_t{19} * 5 * raster.channels();
    for (std::size_t i = 0; i < size; ++i)
        raster.pixels.push_back(static_cast<std::uint8_t>(colours > 0 ? 7 * i % colours : 89 * i % 256));
    return raster;
}

void expect_pixels(const Result<std::string>& file, const DotImage& raster) {
    ASSERT_TRUE(file) << file.error().message;
    const auto read = decode_colour_image(*file, kPixels);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->width, raster.width);
    ASSERT_EQ(read->alpha.empty(), !raster.transparent);
    for (std::size_t i = 0; i < read->red.size(); ++i) {
        const std::uint8_t* const pixel =
            raster.colours > 0 ? raster.palette[raster.pixels[i]].data() : &raster.pixels[raster.channels() * i];
        if (raster.transparent) {
            ASSERT_EQ(std::lround(255 * read->alpha[i]), pixel[3]) << i;
            if (pixel[3] < 255) continue;  // the reader may have rounded the product of light and alpha
        }
        ASSERT_EQ(to_srgb(read->red[i]), pixel[0]) << i;
        ASSERT_EQ(to_srgb(read->green[i]), pixel[1]) << i;
        ASSERT_EQ(to_srgb(read->blue[i]), pixel[2]) << i;
    }
}

TEST(RasterWriters, KeepColours) {
    for (const std::size_t colours : {0U, 2U, 4U, 8U, 16U, 32U, 64U}) {
        for (const bool transparent : {false, true}) {
            SCOPED_TRACE(std::to_string(colours) + (transparent ? " transparent" : ""));
            const DotImage raster = colour_image(colours, transparent);
            expect_pixels(write_png(raster), raster);
            expect_pixels(write_tiff(raster), raster);
            expect_pixels(write_webp(raster), raster);
        }
    }
}

/// The plates of a TIFF as read by a library, and the tags that describe them.
struct Separated {
    std::uint16_t photometric = 0;
    std::uint16_t ink_set = 0;
    std::vector<std::string> names;
    std::vector<std::uint8_t> values;  ///< [width * height * inks]
};

Separated read_separated(const std::string& bytes) {
    const std::string file = testing::TempDir() + "ccdt_plates_" + std::to_string(::getpid()) + ".tiff";
    std::ofstream(file, std::ios::binary) << bytes;
    Separated found;
    TIFF* const tiff = TIFFOpen(file.c_str(), "r");
    std::uint16_t inks = 0;
    const char* names = nullptr;
    std::uint32_t height = 0;
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &found.photometric);
    TIFFGetField(tiff, TIFFTAG_INKSET, &found.ink_set);
    TIFFGetField(tiff, TIFFTAG_NUMBEROFINKS, &inks);
    TIFFGetField(tiff, TIFFTAG_INKNAMES, &names);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    for (int i = 0; i < inks; ++i) {
        found.names.emplace_back(names);
        names += found.names.back().size() + 1;
    }
    const auto row = static_cast<std::size_t>(TIFFScanlineSize(tiff));
    found.values.resize(row * height);
    for (std::uint32_t y = 0; y < height; ++y) TIFFReadScanline(tiff, &found.values[y * row], y, 0);
    TIFFClose(tiff);
    std::filesystem::remove(file);
    return found;
}

TEST(TiffWriter, WritesOneChannelPerPlate) {
    const Palette cmyk{
        {{"cyan", {0, 255, 255}}, {"magenta", {255, 0, 255}}, {"yellow", {255, 255, 0}}, {"black", kBlack}}};
    const Palette two{{{"#c03000", {192, 48, 0}}, {"#003366", {0, 51, 102}}}};
    for (const Palette& palette : {cmyk, two}) {
        std::vector<Raster> plates;
        std::vector<std::string> names;
        for (const Ink& ink : palette.inks) {
            plates.push_back(grey_raster(40));
            std::ranges::rotate(plates.back().coverage, plates.back().coverage.begin() + 5 * std::ssize(plates));
            names.push_back(ink.name);
        }
        const auto file = write_tiff_plates(plates, palette.inks, 10);
        ASSERT_TRUE(file) << file.error().message;
        const Separated found = read_separated(*file);
        EXPECT_EQ(found.photometric, PHOTOMETRIC_SEPARATED);
        EXPECT_EQ(found.ink_set, plates.size() == 4 ? INKSET_CMYK : INKSET_MULTIINK);
        EXPECT_EQ(found.names, names);
        ASSERT_EQ(found.values.size(), plates.size() * plates.front().coverage.size());
        for (std::size_t i = 0; i < found.values.size(); ++i)
            ASSERT_EQ(found.values[i], plates[i % plates.size()].coverage[i / plates.size()]) << i;
    }
}

TEST(PngWriter, UsesFewBitsForFewColours) {
    for (const auto& [colours, bits] : {std::pair{2U, 1}, {4U, 2}, {8U, 4}, {16U, 4}, {64U, 8}, {0U, 8}})
        EXPECT_EQ(decode_png(*write_png(colour_image(colours, false))).bit_depth, bits) << colours;
}

TEST(WebPWriter, RefusesSidesBeyondTheLimitOfTheFormat) {
    const Raster wide{kMaxWebPSide + 1, 1, 1, std::vector<std::uint8_t>(kMaxWebPSide + 1)};
    EXPECT_EQ(write_webp(image_of(wide, true)).error().code, ErrorCode::Internal);
    const Raster widest{kMaxWebPSide, 1, 1, std::vector<std::uint8_t>(kMaxWebPSide)};
    EXPECT_TRUE(write_webp(image_of(widest, true)));
}

TEST(RasterWriters, StopOnRequest) {
    std::stop_source source;
    source.request_stop();
    for (const DotImage& image : {image_of(grey_raster(40), true), colour_image(0, false)}) {
        for (const auto& file :
             {write_png(image, {}, source.get_token()), write_tiff(image, {}, source.get_token()),
              write_webp(image, {}, source.get_token()), write_jpeg(image, 90, {}, source.get_token())})
            EXPECT_EQ(file.error().code, ErrorCode::Stopped);
    }
    const std::vector<Raster> plates = {grey_raster(40)};
    const std::vector<Ink> inks = {{"#000000", kBlack}};
    EXPECT_EQ(write_tiff_plates(plates, inks, {}, source.get_token()).error().code, ErrorCode::Stopped);
}

TEST(RasterWriters, AreDeterministic) {
    const DotImage image = image_of(grey_raster(40), true);
    EXPECT_EQ(*write_tiff(image, 10), *write_tiff(image, 10));
    EXPECT_EQ(*write_webp(image), *write_webp(image));
    EXPECT_EQ(*write_jpeg(image, 90), *write_jpeg(image, 90));
}

}  // namespace
}  // namespace ccdt::api

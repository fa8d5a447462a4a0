#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "api/image/image_codec.h"
#include "api/image/png_writer.h"
#include "api/image/srgb.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
#include "tests/api/files.h"
#include "tests/api/image/rasters.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kPixels = 1 << 20;

/// Every coverage once in each row.
Raster grey_raster() {
    Raster raster{256, 40, 1, std::vector<std::uint8_t>(256 * 40)};
    for (int y = 0; y < 40; ++y) {
        std::iota(raster.coverage.begin() + 256 * y, raster.coverage.begin() + 256 * (y + 1), std::uint8_t{0});
    }
    return raster;
}

/// All writers must tell readers the same picture. That of WebP rounds greys, as three channels, and light times alpha.
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

const std::vector<Inks> kInks = {{},
                                 {kWhite, kBlack},
                                 {{1, 2, 3}, {250, 240, 230}},
                                 {{90, 90, 90}, {200, 200, 200}},
                                 {{9, 8, 7}, {.transparent = true}}};

TEST(TiffWriter, ShowsWhatPngShows) {
    for (const Inks& inks : kInks) {
        expect_same(write_tiff(binary_raster(), false, inks), write_png(binary_raster(), false, inks));
        expect_same(write_tiff(grey_raster(), true, inks), write_png(grey_raster(), true, inks));
    }
}

TEST(WebPWriter, ShowsWhatPngShows) {
    for (const Inks& inks : kInks) {
        expect_same(write_webp(binary_raster(), inks), write_png(binary_raster(), false, inks));
        expect_same(write_webp(grey_raster(), inks), write_png(grey_raster(), true, inks));
    }
}

/// 19 wide, of a palette of so many colours, or of true colours.
ColourRaster colour_raster(std::size_t colours, bool transparent) {
    ColourRaster raster{19, 5, transparent, colours, {}, {}};
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

void expect_pixels(const Result<std::string>& file, const ColourRaster& raster) {
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
            if (pixel[3] < 255) continue;  // a reader may round light times alpha
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
            const ColourRaster raster = colour_raster(colours, transparent);
            expect_pixels(write_png(raster), raster);
            expect_pixels(write_tiff(raster), raster);
            expect_pixels(write_webp(raster), raster);
        }
    }
}

TEST(PngWriter, TakesFewBitsForFewColours) {
    for (const auto& [colours, bits] : {std::pair{2U, 1}, {4U, 2}, {8U, 4}, {16U, 4}, {64U, 8}, {0U, 8}})
        EXPECT_EQ(decode_png(*write_png(colour_raster(colours, false))).bit_depth, bits) << colours;
}

TEST(WebPWriter, RefusesWhatItsFormatCannotHold) {
    const Raster wide{kMaxWebPSide + 1, 1, 1, std::vector<std::uint8_t>(kMaxWebPSide + 1)};
    EXPECT_EQ(write_webp(wide, {}).error().code, ErrorCode::Internal);
    const Raster widest{kMaxWebPSide, 1, 1, std::vector<std::uint8_t>(kMaxWebPSide)};
    EXPECT_TRUE(write_webp(widest, {}));
}

TEST(RasterWriters, EndOnceTheyAreStopped) {
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(write_tiff(grey_raster(), true, {}, {}, source.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(write_webp(grey_raster(), {}, source.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(write_tiff(colour_raster(0, false), {}, source.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(write_webp(colour_raster(0, false), source.get_token()).error().code, ErrorCode::Stopped);
}

TEST(RasterWriters, GiveTheSameBytesAgain) {
    EXPECT_EQ(*write_tiff(grey_raster(), true, {}, 10), *write_tiff(grey_raster(), true, {}, 10));
    EXPECT_EQ(*write_webp(grey_raster(), {}), *write_webp(grey_raster(), {}));
}

}  // namespace
}  // namespace ccdt::api

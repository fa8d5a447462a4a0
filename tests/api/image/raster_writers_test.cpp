#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "api/image/image_codec.h"
#include "api/image/png_writer.h"
#include "api/image/tiff_writer.h"
#include "api/image/webp_writer.h"
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
}

TEST(RasterWriters, GiveTheSameBytesAgain) {
    EXPECT_EQ(*write_tiff(grey_raster(), true, {}, 10), *write_tiff(grey_raster(), true, {}, 10));
    EXPECT_EQ(*write_webp(grey_raster(), {}), *write_webp(grey_raster(), {}));
}

}  // namespace
}  // namespace ccdt::api

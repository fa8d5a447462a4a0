// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/image_codec.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include "api/image/colour_tags.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxPixels = 1'000'000;
constexpr float kTolerance = 0.003F;      // error of JPEG
constexpr float kHeicTolerance = 0.015F;  // the encoder converts colours to YCbCr, with 8 bits

float srgb_to_linear(float value) {
    return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

float luminance_at(const Picture& picture, int x, int y) {
    return picture
        .luminance[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x)];
}

/// Compares a picture with the test picture: four quadrants, 24 x 16.
void expect_quadrants(const Picture& picture, float (*decode)(float), const std::string& name) {
    ASSERT_EQ(picture.width, 24) << name;
    ASSERT_EQ(picture.height, 16) << name;
    ASSERT_EQ(picture.luminance.size(), 24U * 16U) << name;
    EXPECT_TRUE(picture.alpha.empty()) << name;
    const std::vector<std::vector<float>> shades = {{0, 85}, {170, 255}};
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 24; ++x) {
            const float shade = shades[static_cast<std::size_t>(y / 8)][static_cast<std::size_t>(x / 12)];
            ASSERT_NEAR(luminance_at(picture, x, y), decode(shade / 255), kTolerance) << name << ' ' << x << ' ' << y;
        }
    }
}

TEST(ImageCodec, DecodesEveryFormatAlike) {
    for (const auto* name :
         {"grey.jpg",      "progressive.jpg", "cmyk.jpg",       "lossy.webp",    "lossless.webp", "grey-16.png",
          "palette.png",   "lzw.tif",         "big-endian.tif", "tiled.tif",     "grey.gif",      "interlaced.gif",
          "film.gif",      "rgb.bmp",         "indices.bmp",    "from-top.bmp",  "two-bits.bmp",  "four-bits.bmp",
          "runs-4.bmp",    "runs-8.bmp",      "fields.bmp",     "lossless.avif", "lossy.avif",    "grey.avif",
          "lossless.heic", "lossy.heic",      "film.heic",      "gain-map.heic", "gain-map.avif"}) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        expect_quadrants(*picture, srgb_to_linear, name);
    }
}

TEST(ImageCodec, KeepsLinearLight) {
    for (const auto* name : {"linear.png", "float.tif"}) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        expect_quadrants(
            *picture, [](float value) { return value; }, name);
    }
}

TEST(ImageCodec, AppliesTheOrientation) {
    std::vector<std::string> names = {"orientation-6.webp", "orientation-6.tif", "orientation-6.png"};
    for (int i = 1; i <= 8; ++i) {
        names.push_back("orientation-" + std::to_string(i) + ".jpg");
        names.push_back("orientation-" + std::to_string(i) + ".avif");
        names.push_back("orientation-" + std::to_string(i) + ".heic");
    }
    for (const auto& name : names) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        expect_quadrants(*picture, srgb_to_linear, name);
    }
}

TEST(ImageCodec, AppliesTheOrientationToInksWithAndWithoutAProfile) {
    using namespace std::string_literals;
    const std::string mirrored =
        "\xff\xe1\0\x22"s + "Exif\0\0MM\0*\0\0\0\x8\0\1"s + "\1\x12\0\3\0\0\0\1\0\2\0\0\0\0\0\0"s;
    for (const auto* name : {"inks.jpg", "cmyk.jpg"}) {
        const std::string file = fixture(name);
        const auto expected = decode_image(file, kMaxPixels);
        const auto picture = decode_image(file.substr(0, 2) + mirrored + file.substr(2), kMaxPixels);
        ASSERT_TRUE(expected && picture) << name;
        for (int x = 0; x < expected->width; ++x)
            ASSERT_EQ(luminance_at(*picture, x, 0), luminance_at(*expected, expected->width - 1 - x, 0)) << name;
    }
}

/// Returns the mean of a square of pixels.
float mean_of_square(const Picture& picture, int side, int x, int y) {
    float sum = 0;
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) sum += luminance_at(picture, side * x + column, side * y + row);
    }
    return sum / static_cast<float>(side * side);
}

TEST(ImageCodec, DownsamplesByMeanLight) {
    std::vector<std::string> names = {"noise.png", "grey-16.png", "cmyk.jpg", "float.tif", "tiled.tif", "lossy.webp"};
    for (int i = 1; i <= 8; ++i) names.push_back("orientation-" + std::to_string(i) + ".jpg");
    for (const auto& name : names) {
        const auto whole = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(whole) << name;
        for (const int side : {2, 4}) {
            const auto means = decode_image(fixture(name), {kMaxPixels, side});
            ASSERT_TRUE(means) << name;
            ASSERT_EQ(side * means->width, whole->width) << name;
            ASSERT_EQ(side * means->height, whole->height) << name;
            for (int y = 0; y < means->height; ++y) {
                for (int x = 0; x < means->width; ++x)
                    ASSERT_NEAR(luminance_at(*means, x, y), mean_of_square(*whole, side, x, y), 1e-6) << name;
            }
        }
    }
    const auto whole = decode_colour_image(fixture("noise.png"), kMaxPixels);
    const auto means = decode_colour_image(fixture("noise.png"), {kMaxPixels, 2});
    const Picture blue{whole->width, whole->height, whole->blue, {}};
    EXPECT_NEAR(means->blue[0], mean_of_square(blue, 2, 0, 0), 1e-6);
}

TEST(ImageCodec, DownsamplesOnlyOpaqueImagesInWholeBlocks) {
    const auto whole = decode_image(fixture("grey-16.png"), {kMaxPixels, 3});
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->luminance, decode_image(fixture("grey-16.png"), kMaxPixels)->luminance) << "16 rows";
    const auto clear = decode_image(fixture("rgba.png"), {kMaxPixels, 2});
    ASSERT_TRUE(clear);
    EXPECT_EQ(clear->alpha, decode_image(fixture("rgba.png"), kMaxPixels)->alpha);
}

TEST(ImageCodec, ComputesLuminanceAndKeepsAlpha) {
    for (const auto* name : {"rgba.png", "rgba.webp", "premultiplied.tif", "rgba.avif", "premultiplied.avif"}) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        ASSERT_EQ(picture->alpha.size(), 24U) << name;
        for (int x = 1; x < 6; ++x) {
            EXPECT_NEAR(picture->alpha[static_cast<std::size_t>(x)], static_cast<float>(x) / 5, 1e-6) << name;
            EXPECT_NEAR(luminance_at(*picture, x, 0), 0.2126, 1e-4) << name;
            EXPECT_NEAR(luminance_at(*picture, x, 1), 0.7152, 1e-4) << name;
            EXPECT_NEAR(luminance_at(*picture, x, 2), 0.0722, 1e-4) << name;
            // Premultiplied colours have fewer distinct values where alpha is low.
            EXPECT_NEAR(luminance_at(*picture, x, 3), srgb_to_linear(128.0F / 255), 0.01) << name;
        }
        EXPECT_EQ(picture->alpha[0], 0) << name;
    }
}

TEST(ImageCodec, DecodesColourChannels) {
    for (const auto* name : {"rgba.png", "rgba.webp", "premultiplied.tif", "rgba.avif", "premultiplied.avif"}) {
        const auto picture = decode_colour_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        ASSERT_EQ(picture->alpha, decode_image(fixture(name), kMaxPixels)->alpha) << name;
        for (std::size_t x = 1; x < 6; ++x) {
            for (std::size_t y = 0; y < 3; ++y) {
                const std::size_t i = 6 * y + x;
                EXPECT_NEAR(picture->red[i], y == 0 ? 1 : 0, 1e-4) << name;
                EXPECT_NEAR(picture->green[i], y == 1 ? 1 : 0, 1e-4) << name;
                EXPECT_NEAR(picture->blue[i], y == 2 ? 1 : 0, 1e-4) << name;
            }
        }
    }
}

TEST(ImageCodec, ShowsPartlyTransparentPixelsOnTheGround) {
    constexpr Light kGround{1, 0.2140411F, 0};  // sRGB values: 1, 0.5 and 0
    constexpr std::array<float, 3> kValues{1, 0.5F, 0};
    Reading reading(kMaxPixels);
    reading.ground = kGround;
    for (const auto* name : {"rgba.png", "rgba.webp", "premultiplied.tif", "rgba.avif", "premultiplied.avif"}) {
        const auto picture = decode_colour_image(fixture(name), reading);
        const auto grey = decode_image(fixture(name), reading);
        ASSERT_TRUE(picture && grey) << name;
        for (std::size_t i = 0; i < 18; ++i) {  // rows of red, green and blue
            const float alpha = static_cast<float>(i % 6) / 5;
            EXPECT_EQ(picture->alpha[i], alpha > 0 ? 1 : 0) << name;
            EXPECT_EQ(grey->alpha[i], alpha > 0 ? 1 : 0) << name;
            if (alpha == 0) continue;
            const auto seen = [&](std::size_t channel) {
                return srgb_to_linear(std::lerp(kValues[channel], i / 6 == channel ? 1.0F : 0.0F, alpha));
            };
            EXPECT_NEAR(picture->red[i], seen(0), 1e-4) << name << ' ' << i;
            EXPECT_NEAR(picture->green[i], seen(1), 1e-4) << name << ' ' << i;
            EXPECT_NEAR(picture->blue[i], seen(2), 1e-4) << name << ' ' << i;
            EXPECT_NEAR(grey->luminance[i], 0.2126F * seen(0) + 0.7152F * seen(1) + 0.0722F * seen(2), 1e-4) << name;
        }
    }
}

TEST(ImageCodec, ShowsGreyPixelsOnAColouredGround) {
    Reading reading(kMaxPixels);
    reading.ground = {0, 0, 1};
    const auto picture = decode_colour_image(fixture("grey-alpha.png"), reading);
    ASSERT_TRUE(picture);
    EXPECT_NEAR(picture->red[1], srgb_to_linear(0.2F), 1e-4) << "white with an alpha of 0.2";
    EXPECT_EQ(picture->blue[1], 1);
}

TEST(ImageCodec, DecodesGreyFilesToEqualChannels) {
    for (const auto* name : {"grey.jpg", "cmyk.jpg", "grey-16.png", "orientation-6.jpg", "orientation-6.png",
                             "lossy.webp", "float.tif", "tiled.tif"}) {
        const auto grey = decode_image(fixture(name), kMaxPixels);
        const auto picture = decode_colour_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(grey && picture) << name;
        ASSERT_EQ(picture->width, grey->width) << name;
        ASSERT_EQ(picture->blue.size(), grey->luminance.size()) << name;
        for (std::size_t i = 0; i < grey->luminance.size(); ++i) {
            for (const Plane* light : {&picture->red, &picture->green, &picture->blue}) {
                ASSERT_NEAR((*light)[i], grey->luminance[i], 3 * kTolerance) << name << ' ' << i;
            }
        }
    }
}

TEST(ImageCodec, ReadsGreyWithAlphaAndTransparentPalettes) {
    const auto grey = decode_image(fixture("grey-alpha.png"), kMaxPixels);
    ASSERT_TRUE(grey);
    EXPECT_NEAR(grey->alpha[1], 0.2, 1e-6);
    EXPECT_NEAR(luminance_at(*grey, 1, 0), 1, 1e-6);
    const auto of_avif = decode_image(fixture("grey-alpha.avif"), kMaxPixels);
    ASSERT_TRUE(of_avif);
    EXPECT_NEAR(of_avif->alpha[1], 0.2, 1e-6);
    const auto palette = decode_image(fixture("palette-transparent.png"), kMaxPixels);
    ASSERT_TRUE(palette);
    EXPECT_EQ(palette->alpha, (Plane{1, 0, 1, 1}));
    EXPECT_NEAR(luminance_at(*palette, 2, 0), 0.7152, 1e-4);
}

TEST(ImageCodec, AppliesProfilesInEveryFormat) {
    // White, two colours, and a red outside sRGB, which is mixed with grey of its luminance until it fits.
    const std::vector<std::vector<float>> expected = {
        {1, 1, 1}, {0.67884F, 0.10851F, 0.01367F}, {0, 0.34667F, 0.11374F}, {1, 0.01914F, 0.03650F}};
    for (const auto* name : {"p3.png", "p3.webp", "p3.tif", "p3.jpg", "p3-chromaticities.png", "p3-code-points.png",
                             "p3.avif", "p3-code-points.avif", "p3.heic"}) {
        const auto picture = decode_colour_image(fixture(name), kMaxPixels);
        const auto grey = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture && grey) << name;
        const bool is_jpeg = picture->width > 4;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t at = is_jpeg ? 16 * i + 8 : i;
            const bool is_exact = !is_jpeg && !std::string_view(name).ends_with(".heic");
            const float tolerance = is_exact ? 0.001F : 0.01F;
            EXPECT_NEAR(picture->red[at], expected[i][0], tolerance) << name << ' ' << i;
            EXPECT_NEAR(picture->green[at], expected[i][1], tolerance) << name << ' ' << i;
            EXPECT_NEAR(picture->blue[at], expected[i][2], tolerance) << name << ' ' << i;
            const float weighed =
                0.2126F * picture->red[at] + 0.7152F * picture->green[at] + 0.0722F * picture->blue[at];
            EXPECT_NEAR(grey->luminance[at], weighed, 1e-6F) << name << ' ' << i;
        }
        EXPECT_EQ(grey->luminance[0], 1) << name << ": white must be exactly 1, so that it gets no dots";
    }
}

TEST(ImageCodec, AppliesCmykProfiles) {
    const std::vector<std::vector<float>> expected = {
        {1, 1, 1}, {0.05F, 0.35F, 0.75F}, {0.66093F, 0.42940F, 0.41724F}, {0.01F, 0.01F, 0.01F}};
    for (const auto* name : {"inks.tif", "inks.jpg"}) {
        const auto picture = decode_colour_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t at = picture->width > 4 ? 16 * i + 8 : i;
            EXPECT_NEAR(picture->red[at], expected[i][0], 0.02) << name << ' ' << i;
            EXPECT_NEAR(picture->green[at], expected[i][1], 0.02) << name << ' ' << i;
            EXPECT_NEAR(picture->blue[at], expected[i][2], 0.02) << name << ' ' << i;
        }
        EXPECT_EQ(decode_image(fixture(name), kMaxPixels)->luminance[0], 1) << name;
    }
}

TEST(ImageCodec, KeepsTheValuesOfSrgbProfiles) {
    const std::string file = fixture("srgb.png");
    const auto picture = decode_colour_image(file, kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->red[1], srgb_to_linear(200.0F / 255));
    EXPECT_EQ(picture->green[1], srgb_to_linear(100.0F / 255));
}

TEST(ImageCodec, PreservesSixteenBits) {
    for (const auto* name : {"ramp.png", "ramp.tif", "ramp-gamma.png"}) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name;
        ASSERT_EQ(picture->luminance.size(), 65536U) << name;
        for (std::size_t i = 1; i < 65536; ++i)
            ASSERT_GT(picture->luminance[i], picture->luminance[i - 1]) << name << ' ' << i;
    }
    EXPECT_NEAR(decode_image(fixture("ramp-gamma.png"), kMaxPixels)->luminance[32768], std::pow(0.5, 461.0 / 256),
                1e-4);
}

TEST(ImageCodec, HidesInvalidProfilesFromTheLibrary) {
    for (const auto* name : {"profile-beyond.tif", "profile-beyond.png", "profile-beyond.jpg"}) {
        EXPECT_TRUE(decode_image(fixture(name), kMaxPixels)) << name;
    }
}

TEST(ImageCodec, DecodesGifs) {
    EXPECT_EQ(decode_colour_image(fixture("noise.gif"), kMaxPixels)->red,
              decode_colour_image(fixture("noise.png"), kMaxPixels)->red);
}

TEST(ImageCodec, DecodesGifsWithoutTheirLastTwoBytes) {
    const std::string file = fixture("noise.gif");
    ASSERT_TRUE(file.ends_with(std::string_view("\0;", 2)));
    const auto picture = decode_image(std::string_view(file).substr(0, file.size() - 2), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->luminance, decode_image(file, kMaxPixels)->luminance);
}

TEST(ImageCodec, DecodesLosslessAvifsAndHeicsExactly) {
    const auto expected = decode_colour_image(fixture("noise.png"), kMaxPixels);
    for (const std::string suffix : {".avif", ".heic"}) {
        const auto whole = decode_colour_image(fixture("noise" + suffix), kMaxPixels);
        const auto tiles = decode_colour_image(fixture("tiles" + suffix), kMaxPixels);
        ASSERT_TRUE(whole && tiles) << suffix;
        EXPECT_EQ(whole->red, expected->red) << suffix;
        EXPECT_EQ(whole->green, expected->green) << suffix;
        EXPECT_EQ(whole->blue, expected->blue) << suffix;
        ASSERT_EQ(tiles->width, 128) << suffix;
        ASSERT_EQ(tiles->height, 64) << suffix;
        for (std::size_t y = 0; y < 64; ++y) {
            for (std::size_t x = 0; x < 64; ++x) {
                ASSERT_EQ(tiles->blue[128 * y + x], expected->blue[96 * y + x]) << suffix << x << ' ' << y;
                ASSERT_NEAR(tiles->red[128 * y + x + 64], 1, kHeicTolerance) << suffix << x << ' ' << y;
                ASSERT_EQ(tiles->blue[128 * y + x + 64], 0) << suffix << x << ' ' << y;
            }
        }
    }
}

TEST(ImageCodec, RoundsCropsOfHeicsDown) {
    std::string file = fixture("orientation-1.heic");
    const auto whole = decode_image(file, kMaxPixels);
    const std::size_t crop = file.find("clap") + 4;
    ASSERT_EQ(file.substr(crop, 8), std::string("\0\0\0\x18\0\0\0\1", 8));
    file.replace(crop, 8, std::string("\0\0\0\x2f\0\0\0\2", 8));  // 23.5 pixels instead of 24
    const auto rounded = decode_image(file, kMaxPixels);
    ASSERT_TRUE(whole && rounded);
    EXPECT_EQ(whole->width, 24);
    EXPECT_EQ(rounded->width, 23);
    EXPECT_EQ(rounded->height, 16);
    EXPECT_EQ(rounded->luminance[1], whole->luminance[1]);
}

TEST(ImageCodec, ReadsTheAlphaOfHeics) {
    for (const auto* name : {"rgba.heic", "premultiplied.heic"}) {
        const auto picture = decode_colour_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        ASSERT_EQ(picture->alpha.size(), 24U) << name;
        for (std::size_t x = 0; x < 6; ++x) {
            EXPECT_NEAR(picture->alpha[x], static_cast<float>(x) / 5, 1e-6) << name;
            if (x < 3) continue;  // premultiplied colours are coarse where alpha is low
            EXPECT_NEAR(picture->red[x], 1, kHeicTolerance) << name;
            EXPECT_NEAR(picture->green[6 + x], 1, kHeicTolerance) << name;
            EXPECT_NEAR(picture->green[x], 0, kHeicTolerance) << name;
        }
    }
}

TEST(ImageCodec, ReadsAvifsThatEndWithABoxWithoutASize) {
    using namespace std::string_literals;
    std::string file = fixture("lossless.avif");
    const std::size_t meta = file.find("meta") - 4, data = file.rfind("mdat") - 4;
    const auto offset = static_cast<char>(meta + 8);  // of the pixels, which then come first
    file.replace(file.find("\0\0\1\x1a"s), 4, "\0\0\0"s + offset);
    file.replace(meta, 4, 4, '\0');
    const auto picture =
        decode_image(file.substr(0, meta) + file.substr(data) + file.substr(meta, data - meta), kMaxPixels);
    ASSERT_TRUE(picture) << picture.error().message;
    expect_quadrants(*picture, srgb_to_linear, "lossless.avif");
}

TEST(ImageCodec, ReadsAvifsWithSound) {
    constexpr std::size_t kHeader = 104, kSize = 8;  // of a track; the header ends with the size, which sound lacks
    std::string file = fixture("film.avif");
    const auto expected = decode_image(file, kMaxPixels);
    file.replace(file.rfind("tkhd") - 4 + kHeader - kSize, kSize, kSize, '\0');
    const auto picture = decode_image(file, kMaxPixels);
    ASSERT_TRUE(expected && picture);
    EXPECT_EQ(picture->luminance, expected->luminance);
}

TEST(ImageCodec, AppliesColoursThatOnlyTheCodedPictureDeclares) {
    std::string file = fixture("p3-code-points.avif");
    const auto expected = decode_colour_image(file, kMaxPixels);
    const auto picture = decode_colour_image(file.replace(file.find("colr"), 4, "free"), kMaxPixels);
    ASSERT_TRUE(expected && picture);
    EXPECT_EQ(picture->red, expected->red);
}

TEST(ImageCodec, CropsAvifs) {
    const auto picture = decode_image(fixture("cropped.avif"), kMaxPixels);
    const auto whole = decode_image(fixture("lossless.avif"), kMaxPixels);
    ASSERT_TRUE(picture && whole);
    ASSERT_EQ(picture->width, 12);
    ASSERT_EQ(picture->height, 16);
    for (std::size_t i = 0; i < picture->luminance.size(); ++i)
        EXPECT_NEAR(picture->luminance[i], whole->luminance[i / 12 * 24 + 6 + i % 12], 0.02) << i;
}

TEST(ImageCodec, ReadsThePrimaryItemOfAnAnimatedAvif) {
    const auto picture = decode_image(fixture("film.avif"), kMaxPixels);
    const auto expected = decode_image(fixture("lossless.avif"), kMaxPixels);
    ASSERT_TRUE(picture && expected);
    EXPECT_EQ(picture->luminance, expected->luminance);
}

TEST(ImageCodec, PreservesTwelveBits) {
    for (const auto* name : {"ramp.avif", "ramp.heic"}) {
        const auto picture = decode_image(fixture(name), kMaxPixels);
        ASSERT_TRUE(picture) << name;
        for (std::size_t i = 17; i < 65536; i += 17)
            ASSERT_GT(picture->luminance[i], picture->luminance[i - 17]) << name << ' ' << i;
    }
}

TEST(ImageCodec, MirrorsHeicsOfTwelveBits) {
    std::string file = fixture("ramp.heic");
    const auto upright = decode_image(file, kMaxPixels);
    file.replace(file.find("pixi"), 4, "imir");  // its first byte means from top to bottom
    const auto mirrored = decode_image(file, kMaxPixels);
    ASSERT_TRUE(upright && mirrored) << mirrored.error().message;
    for (int y = 0; y < 256; ++y) ASSERT_EQ(luminance_at(*mirrored, y, y), luminance_at(*upright, y, 255 - y)) << y;
}

TEST(ImageCodec, RefusesAvifsAndHeicsLargerThanTheirHeader) {
    for (const auto* name : {"lossless.avif", "noise.avif", "tiles.avif", "noise.heic", "tiles.heic"}) {
        std::string file = fixture(name);
        --file[file.find("ispe") + 11];
        const auto picture = decode_image(file, kMaxPixels);
        ASSERT_FALSE(picture) << name;
        EXPECT_EQ(picture.error().code, ErrorCode::Unusable) << name;
    }
}

TEST(ImageCodec, SurroundsAPartialGifFrameByTransparency) {
    const auto picture = decode_image(fixture("part.gif"), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->width, 4);
    EXPECT_EQ(picture->height, 3);
    Plane expected{0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
    EXPECT_EQ(picture->alpha, expected);
    EXPECT_NEAR(luminance_at(*picture, 1, 1), 0.2126, 1e-4);
}

TEST(ImageCodec, ShowsGifFramesBeyondTheScreen) {
    std::string file = fixture("noise.gif");
    const auto whole = decode_image(file, kMaxPixels);
    file[6] = file[8] = 1;  // the screen has 1 x 1 pixel
    file[7] = file[9] = 0;
    const auto picture = decode_image(file, kMaxPixels);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->luminance, whole->luminance);
    EXPECT_EQ(picture->width, whole->width);

    std::string grey = fixture("grey.gif");  // 24 x 16 pixels
    const std::size_t frame = grey.find(std::string_view("\x2c\0\0\0\0\x18", 6));
    ASSERT_NE(frame, std::string::npos);
    grey[frame + 1] = 20;
    const auto part = decode_image(grey, kMaxPixels);
    ASSERT_TRUE(part) << part.error().message;
    EXPECT_EQ(part->width, 44);
    EXPECT_EQ(part->height, 16);
    EXPECT_EQ(std::ranges::count(part->alpha, 1.0F), 24 * 16);
    EXPECT_EQ(part->alpha[19], 0.0F);
    EXPECT_EQ(part->alpha[20], 1.0F);
}

TEST(ImageCodec, ShowsGifsWithoutAPaletteInBlack) {
    constexpr std::size_t kFlags = 10, kPalette = 13;
    std::string file = fixture("grey.gif");
    const std::size_t size = std::size_t{6} << (file[kFlags] & 7);
    file[kFlags] = static_cast<char>(file[kFlags] & 0x7F);
    const auto picture = decode_image(file.erase(kPalette, size), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(std::ranges::count(picture->luminance, 0.0F), 24 * 16);
}

TEST(ImageCodec, ReadsBmpsWithoutTheirLastBytes) {
    // The last row of 23 pixels of 24 bits ends with three bytes of padding, which are last in the file.
    std::string file = fixture("rgb.bmp");
    const auto whole = decode_image(file, kMaxPixels);
    file[18] = 23;
    const auto padded = decode_image(file, kMaxPixels);
    ASSERT_TRUE(padded);
    for (const std::size_t missing : {1U, 2U, 3U}) {
        const auto picture = decode_image(std::string_view(file).substr(0, file.size() - missing), kMaxPixels);
        ASSERT_TRUE(picture) << missing;
        EXPECT_EQ(picture->luminance, padded->luminance) << missing;
    }
    EXPECT_FALSE(decode_image(std::string_view(file).substr(0, file.size() - 4), kMaxPixels));
    const std::string runs = fixture("runs-8.bmp");
    ASSERT_TRUE(runs.ends_with(std::string_view("\0\0\0\1", 4)) || runs.ends_with(std::string_view("\0\1", 2)));
    const std::size_t marks = runs.ends_with(std::string_view("\0\0\0\1", 4)) ? 4 : 2;
    const auto picture = decode_image(std::string_view(runs).substr(0, runs.size() - marks), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->luminance, decode_image(runs, kMaxPixels)->luminance);
}

/// Returns a PNG with another chunk before its other chunks.
std::string with_chunk(std::string png, const std::string& name, const std::string& data) {
    constexpr std::size_t kAfterHeader = 33;
    const auto big_endian = [](std::uint64_t value) {
        std::string bytes;
        for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
        return bytes;
    };
    const std::string body = name + data;
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    return png.insert(kAfterHeader, big_endian(data.size()) + body + big_endian(sum));
}

TEST(ImageCodec, IgnoresTextsAndOffsetsInPngs) {
    using namespace std::string_literals;
    const std::string file = fixture("noise.png");
    const auto expected = decode_colour_image(file, kMaxPixels);
    const std::vector<std::pair<std::string, std::string>> chunks = {{"tEXt", "Orientation\0006"s},
                                                                     {"tEXt", "oiio:ColorSpace\0Linear"s},
                                                                     {"tEXt", "oiio:Gamma\0003"s},
                                                                     {"iTXt", "Orientation\0\0\0\0\0006"s},
                                                                     {"tEXt", "oiio:UnassociatedAlpha\0000"s},
                                                                     {"oFFs", "\0\0\0\5\0\0\0\7\0"s},
                                                                     {"oFFs", "\xff\xff\xff\xf0\xff\xff\xff\xf0\0"s}};
    for (const auto& [name, data] : chunks) {
        const auto picture = decode_colour_image(with_chunk(file, name, data), kMaxPixels);
        ASSERT_TRUE(picture) << data << ": " << picture.error().message;
        EXPECT_EQ(picture->width, expected->width) << data;
        EXPECT_EQ(picture->red, expected->red) << data;
        EXPECT_EQ(picture->alpha, expected->alpha) << data;
    }
}

TEST(ImageCodec, KeepsTheTransparentColourBeforeASuggestedPalette) {
    using namespace std::string_literals;
    const std::string palette = with_chunk(fixture("srgb.png"), "PLTE", "\0\0\0\x80\x80\x80"s);
    const auto picture = decode_image(with_chunk(palette, "tRNS", "\0\xff\0\0\0\0"s), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->alpha, (Plane{1, 1, 1, 0}));
}

TEST(ImageCodec, IgnoresTheGammaOfAPngWithBetterColourTags) {
    using namespace std::string_literals;
    const std::string code_points = with_chunk(fixture("noise.png"), "cICP", "\1\15\0\1"s);
    for (const auto& file : {fixture("srgb.png"), code_points, with_chunk(fixture("noise.png"), "sRGB", "\0"s)}) {
        const auto expected = decode_colour_image(file, kMaxPixels);
        const auto picture = decode_colour_image(with_chunk(file, "gAMA", "\0\1\x86\xa0"s), kMaxPixels);
        ASSERT_TRUE(expected && picture);
        EXPECT_EQ(picture->green, expected->green);
    }
}

TEST(ImageCodec, TakesVideoCurvesAsSrgb) {
    const std::string file = fixture("noise.png");
    const auto expected = decode_colour_image(file, kMaxPixels);
    for (const char transfer : {'\1', '\6', '\15', '\16', '\17'}) {
        const auto picture = decode_colour_image(with_chunk(file, "cICP", {'\1', transfer, '\0', '\1'}), kMaxPixels);
        ASSERT_TRUE(picture);
        EXPECT_EQ(picture->green, expected->green) << int{transfer};
    }
}

TEST(ImageCodec, ReadsJpegsWithFaultsThatViewersIgnore) {
    using namespace std::string_literals;
    for (const auto* name : {"grey.jpg", "progressive.jpg", "cmyk.jpg", "p3.jpg", "inks.jpg", "orientation-6.jpg"}) {
        const std::string file = fixture(name);
        const auto expected = decode_image(file, kMaxPixels);
        ASSERT_TRUE(expected);
        for (const char* marker : {"\xff\xdb", "\xff\xc4"}) {
            for (const auto& junk : {"\0\0\0\0"s, "junk"s, "\xff\xff"s, "\1\xff\0\2"s}) {
                std::string changed = file;
                const auto picture = decode_image(changed.insert(changed.find(marker), junk), kMaxPixels);
                ASSERT_TRUE(picture) << name << ' ' << junk << ": " << picture.error().message;
                EXPECT_EQ(picture->luminance, expected->luminance) << name;
            }
        }
        for (const std::size_t missing : {1U, 2U}) {
            const auto picture = decode_image(std::string_view(file).substr(0, file.size() - missing), kMaxPixels);
            ASSERT_TRUE(picture) << name << ' ' << missing << ": " << picture.error().message;
            EXPECT_EQ(picture->luminance, expected->luminance) << name;
        }
        EXPECT_TRUE(decode_image(file + "bytes after the end", kMaxPixels)) << name;
        for (const auto& empty : {"\xff\xfe\0\0"s, "\xff\xfe\0\1"s, "\xff\xef\0\0"s}) {
            const auto picture = decode_image(file.substr(0, 2) + empty + file.substr(2), kMaxPixels);
            ASSERT_TRUE(picture) << name << ": " << picture.error().message;
            EXPECT_EQ(picture->luminance, expected->luminance) << name;
        }
    }
}

TEST(ImageCodec, IgnoresUnknownValuesInHeadersOfJpegs) {
    using namespace std::string_literals;
    const auto expect_equal = [](const std::string& changed, const std::string& file, const char* what) {
        const auto picture = decode_image(changed, kMaxPixels), expected = decode_image(file, kMaxPixels);
        ASSERT_TRUE(expected);
        ASSERT_TRUE(picture) << what << ": " << picture.error().message;
        EXPECT_EQ(picture->luminance, expected->luminance) << what;
    };
    const std::string adobe = "\xff\xee\0\x0e"s + "Adobe\0\x64\0\0\0\0"s;
    for (const auto* name : {"grey.jpg", "progressive.jpg", "orientation-6.jpg", "p3.jpg"}) {
        const std::string file = fixture(name);
        std::string changed = file;
        changed[file.find("JFIF") + 5] = 2;
        expect_equal(changed, file, "version of JFIF");
        for (const char transform : {'\2', '\5'}) {
            const std::string start = file.substr(0, 2) + adobe + transform;
            expect_equal(start + file.substr(2), file, "transform of Adobe, with JFIF");
            expect_equal(start + file.substr(20), file, "transform of Adobe");
        }
    }
    for (const auto* name : {"grey.jpg", "orientation-6.jpg", "p3.jpg", "inks.jpg", "cmyk.jpg"}) {
        const std::string file = fixture(name);
        const std::size_t scan = file.find("\xff\xda");
        for (const auto& range : {"\0\0\0"s, "\1\x3f\0"s, "\0\x3f\x10"s}) {
            std::string changed = file;
            changed.replace(scan + 5 + 2 * static_cast<std::size_t>(file[scan + 4]), 3, range);
            expect_equal(changed, file, "spectral range of a sequential scan");
        }
    }
    for (const auto* name : {"inks.jpg", "cmyk.jpg"}) {
        std::string file = fixture(name), changed = file;
        file[file.find("Adobe") + 11] = 2;
        changed[file.find("Adobe") + 11] = 1;
        expect_equal(changed, file, "transform of Adobe, with four channels");
    }
}

TEST(ImageCodec, RefusesGifFramesOfTheWrongSize) {
    for (const std::size_t at : {32U, 34U}) {  // width, height
        for (const char size : {'\0', '\4'}) {
            std::string file = fixture("part.gif");
            file[at] = size;
            EXPECT_EQ(decode_image(file, kMaxPixels).error().code, ErrorCode::Unusable) << at;
        }
    }
}

TEST(ImageCodec, ReadsBitFieldsOfBmps) {
    const auto fifths = decode_image(fixture("sixteen-bits.bmp"), kMaxPixels);
    ASSERT_TRUE(fifths);
    EXPECT_NEAR(luminance_at(*fifths, 23, 0), srgb_to_linear(10.0F / 31), 1e-4);
    const auto alpha = decode_image(fixture("alpha.bmp"), kMaxPixels);
    ASSERT_TRUE(alpha);
    ASSERT_EQ(alpha->alpha.size(), 6U);
    for (std::size_t x = 0; x < 6; ++x) EXPECT_NEAR(alpha->alpha[x], static_cast<float>(x) / 5, 1e-6);
    EXPECT_NEAR(luminance_at(*alpha, 3, 0), 0.2126, 1e-4);
    EXPECT_TRUE(decode_image(fixture("no-alpha.bmp"), kMaxPixels)->alpha.empty());
}

/// Returns a BMP of one row of uncompressed pixels of 32 bits, with a header of version 5.
std::string bmp_of_version_5(const std::vector<std::uint32_t>& pixels, std::uint32_t alpha, std::string_view profile) {
    constexpr std::uint32_t kFileHeader = 14, kHeader = 124, kEmbedded = 0x4D424544;
    const auto width = static_cast<std::uint32_t>(pixels.size()), begin = kFileHeader + kHeader;
    std::string file = "BM" + std::string(begin - 2, '\0');
    const auto write = [&](std::size_t at, std::uint32_t value) {
        for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(value >> 8 * i & 255);
    };
    for (const auto& [at, value] : std::vector<std::pair<std::size_t, std::uint32_t>>{
             {10, begin}, {14, kHeader}, {18, width}, {22, 1}, {26, 1 | 32U << 16}, {66, alpha}})
        write(at, value);
    if (!profile.empty()) {
        for (const auto& [at, value] : std::vector<std::pair<std::size_t, std::uint32_t>>{
                 {70, kEmbedded}, {126, kHeader + 4 * width}, {130, static_cast<std::uint32_t>(profile.size())}})
            write(at, value);
    }
    file.resize(begin + 4 * pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) write(begin + 4 * i, pixels[i]);
    return file.append(profile);
}

TEST(ImageCodec, AppliesProfilesOfBmps) {
    const std::string png = fixture("p3.png");
    const std::string profile = read_colour_tags(png, ImageFormat::Png).profile;
    const std::string file = bmp_of_version_5({0xFFFFFF, 0xC86432, 0x28A05A, 0xFF0000}, 0, profile);
    const auto expected = decode_colour_image(png, kMaxPixels), picture = decode_colour_image(file, kMaxPixels);
    ASSERT_TRUE(expected && picture);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(picture->red[i], expected->red[i], 1e-4) << i;
        EXPECT_NEAR(picture->green[i], expected->green[i], 1e-4) << i;
        EXPECT_NEAR(picture->blue[i], expected->blue[i], 1e-4) << i;
    }
    const auto cut = decode_colour_image(std::string_view(file).substr(0, file.size() - 1), kMaxPixels);
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->red[3], 1) << "a profile beyond the end of the file is ignored";
    EXPECT_EQ(cut->green[3], 0);
}

TEST(ImageCodec, ReadsAlphaOfUncompressedBmps) {
    const auto picture = decode_image(bmp_of_version_5({0xFFFF0000, 0x33FF0000}, 0xFF000000, ""), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->alpha, (Plane{1, 0.2F}));
    for (const std::uint32_t mask : {0U, 0xFF000000U})
        EXPECT_TRUE(decode_image(bmp_of_version_5({0x00FF0000}, mask, ""), kMaxPixels)->alpha.empty()) << mask;
}

TEST(ImageCodec, ReadsPhotographs) {
    const auto picture = decode_image(photograph("chelsea.png"), kMaxPixels);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->width, 451);
    EXPECT_EQ(picture->height, 300);
}

TEST(ImageCodec, ChecksTheSizeBeforeDecoding) {
    for (const auto* name : {"bomb.png", "bomb.webp", "bomb.gif", "bomb.bmp", "bomb.avif", "bomb.heic"}) {
        const auto picture = decode_image(fixture(name), 64'000'000);
        ASSERT_FALSE(picture) << name;
        EXPECT_EQ(picture.error().code, ErrorCode::LimitExceeded) << name;
        EXPECT_NE(picture.error().message.find("max-pixels"), std::string::npos);
        EXPECT_NE(picture.error().message.find("64000000"), std::string::npos);
    }
    constexpr std::size_t kPixels = std::size_t{24} * 16;
    EXPECT_TRUE(decode_image(fixture("grey.jpg"), kPixels));
    EXPECT_FALSE(decode_image(fixture("grey.jpg"), kPixels - 1));
}

TEST(ImageCodec, RefusesTilesMuchLargerThanTheTiff) {
    const auto picture = decode_image(fixture("huge-tile.tif"), kMaxPixels);
    ASSERT_FALSE(picture);
    EXPECT_EQ(picture.error().code, ErrorCode::Unusable);
    EXPECT_NE(picture.error().message.find("tiles much larger than the picture"), std::string::npos);
}

TEST(ImageCodec, ReadsTiffsWithoutBitsPerSample) {
    const auto picture = decode_image(fixture("bits-missing.tif"), kMaxPixels);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(luminance_at(*picture, 23, 0), 0);
    EXPECT_EQ(luminance_at(*picture, 0, 15), 1);
}

TEST(ImageCodec, RefusesTruncatedFiles) {
    std::vector<std::string> files = {photograph("chelsea.png")};
    for (const auto* name :
         {"lossless.webp", "lossy.webp", "tiled.tif", "orientation-1.jpg", "grey.jpg", "big-endian.tif", "grey.gif",
          "noise.gif", "rgb.bmp", "runs-8.bmp", "runs-4.bmp", "fields.bmp", "lossless.avif", "noise.avif", "tiles.avif",
          "lossless.heic", "noise.heic", "tiles.heic"}) {
        files.push_back(fixture(name));
    }
    for (const auto& file : files) {
        for (const double share : {0.1, 0.5, 0.9}) {
            const auto size = static_cast<std::size_t>(share * static_cast<double>(file.size()));
            const auto picture = decode_image(file.substr(0, size), kMaxPixels);
            ASSERT_FALSE(picture) << file.substr(0, 4) << ' ' << share;
            EXPECT_NE(picture.error().code, ErrorCode::Internal);
            EXPECT_EQ(picture.error().message.find('/'), std::string::npos) << "the message may contain a path";
        }
    }
}

TEST(ImageCodec, SurvivesDamagedFiles) {
    std::mt19937 random(7);
    for (const auto* name : {"orientation-6.jpg",
                             "progressive.jpg",
                             "cmyk.jpg",
                             "orientation-6.webp",
                             "rgba.webp",
                             "lossy.webp",
                             "palette-transparent.png",
                             "grey-16.png",
                             "lzw.tif",
                             "tiled.tif",
                             "premultiplied.tif",
                             "orientation-6.tif",
                             "p3.png",
                             "p3.jpg",
                             "p3.tif",
                             "interlaced.gif",
                             "part.gif",
                             "runs-4.bmp",
                             "runs-8.bmp",
                             "fields.bmp",
                             "lossy.avif",
                             "rgba.avif",
                             "premultiplied.avif",
                             "ramp.avif",
                             "tiles.avif",
                             "film.avif",
                             "lossy.heic",
                             "rgba.heic",
                             "ramp.heic",
                             "tiles.heic",
                             "orientation-5.heic",
                             "gain-map.heic"}) {
        const std::string file = fixture(name);
        for (int round = 0; round < 200; ++round) {
            std::string damaged = file;
            for (unsigned i = 0; i < 1 + random() % 4; ++i) {
                damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
            }
            const auto picture = decode_image(damaged, kMaxPixels);
            if (!picture) continue;
            for (const float value : picture->luminance) ASSERT_TRUE(value >= 0 && value <= 1) << name;
            for (const float value : picture->alpha) ASSERT_TRUE(value >= 0 && value <= 1) << name;
        }
    }
}

TEST(ImageCodec, IsIdenticalOnManyThreads) {
    const std::string file = fixture("lzw.tif");
    const auto expected = decode_image(file, kMaxPixels);
    std::vector<std::jthread> threads;
    threads.reserve(4);
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            for (int round = 0; round < 20; ++round) {
                EXPECT_EQ(decode_image(file, kMaxPixels)->luminance, expected->luminance);
            }
        });
    }
}

}  // namespace
}  // namespace ccdt::api

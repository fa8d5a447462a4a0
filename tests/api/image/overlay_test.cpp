// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/overlay.h"

#include <gtest/gtest.h>

#include <numeric>

#include "api/input/option_reader.h"
#include "core/base/thread_executor.h"

namespace ccdt::api {
namespace {

using Rgba = std::array<std::uint8_t, 4>;

Raster raster(std::vector<std::uint8_t> coverage) {
    return {static_cast<int>(coverage.size()), 1, 1, std::move(coverage)};
}

Palette palette_of(const char* color) {
    return *read_color({"color", "color", color});
}

Rgba pixel(const DotImage& picture, std::size_t x) {
    if (picture.colours > 0) return picture.palette[picture.pixels[x]];
    Rgba colour = {0, 0, 0, 255};
    std::copy_n(&picture.pixels[x * picture.channels()], picture.channels(), colour.begin());
    return colour;
}

std::vector<Rgba> pixels(const DotImage& picture) {
    std::vector<Rgba> all;
    for (int x = 0; x < picture.width; ++x) all.push_back(pixel(picture, static_cast<std::size_t>(x)));
    return all;
}

const std::vector<Rgba> kRainbow = {{255, 255, 255, 255}, {0, 255, 255, 255}, {0, 0, 255, 255}, {0, 255, 0, 255},
                                    {255, 0, 0, 255},     {0, 0, 0, 255},     {0, 0, 0, 255}};

TEST(Overlay, MultipliesInks) {
    const std::vector<Raster> inks = {raster({0, 255, 255, 255, 0, 255, 0}), raster({0, 0, 255, 0, 255, 255, 0}),
                                      raster({0, 0, 0, 255, 255, 255, 0}), raster({0, 0, 0, 0, 0, 0, 255})};
    for (const bool antialias : {false, true}) {
        const DotImage picture = overlay(inks, palette_of("cmyk"), antialias);
        EXPECT_EQ(picture.colours, antialias ? 0U : 16U);
        EXPECT_EQ(pixels(picture), kRainbow) << antialias;
    }
}

TEST(Overlay, AddsLights) {
    const std::vector<Raster> lights = {raster({0, 255, 255, 255}), raster({0, 0, 255, 255}), raster({0, 0, 0, 255})};
    const std::vector<Rgba> expected = {{0, 0, 0, 255}, {255, 0, 0, 255}, {255, 255, 0, 255}, {255, 255, 255, 255}};
    for (const bool antialias : {false, true})
        EXPECT_EQ(pixels(overlay(lights, palette_of("rgb"), antialias)), expected);
}

TEST(Overlay, IsIdenticalOnAnyExecutor) {
    std::vector<std::uint8_t> some(100'003);
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = i * i % 7 < 3 ? 255 : 0;
    const std::vector<std::uint8_t> others(some.rbegin(), some.rend());
    const std::vector<Raster> inks = {raster(some), raster(others), raster(some)};
    ThreadExecutor executor(3);
    for (const char* color : {"gray", "rgb"}) {
        for (const bool antialias : {false, true}) {
            const Palette palette = palette_of(color);
            EXPECT_EQ(overlay(inks, palette, antialias, {}, executor).pixels, overlay(inks, palette, antialias).pixels);
        }
    }
}

/// Checks that a single ink has the same colours as in grey mode, for every coverage and paper.
TEST(Overlay, UsesTheShadesOfASingleInk) {
    std::vector<std::uint8_t> all(256);
    std::iota(all.begin(), all.end(), std::uint8_t{0});
    for (const Colour& paper : {kWhite, Colour{.transparent = true}}) {
        const Colour ink = {200, 30, 90};
        const DotImage picture = overlay(std::vector{raster(all)}, {{{"ink", ink}}, paper, Mixing::Multiply}, true);
        EXPECT_EQ(picture.transparent, paper.transparent);
        const Shades shades = shades_of(ink, paper);
        for (std::size_t i = 1; i < 256; ++i) {
            const Rgba seen = pixel(picture, i);
            for (std::size_t channel = 0; channel < 4; ++channel) {
                // Colours of the smallest coverages, recovered from eight bits, are inexact.
                EXPECT_NEAR(seen[channel], shades[i][channel], 1) << i << ' ' << channel;
            }
        }
    }
}

TEST(Overlay, CoversThePaperWithAnOpaqueInk) {
    const Palette palette{{{"", {255, 0, 0}}}, {0, 255, 255}, Mixing::Cover};
    const std::vector<Rgba> expected = {{0, 255, 255, 255}, {255, 0, 0, 255}};
    for (const bool antialias : {false, true}) {
        const DotImage picture = overlay(std::vector{raster({0, 255})}, palette, antialias);
        EXPECT_EQ(picture.colours, antialias ? 256U : 2U);
        EXPECT_EQ(pixels(picture), expected) << antialias;
    }
}

TEST(Overlay, RecognizesGreyAndBilevelPictures) {
    const auto image = [](const Colour& ink, const Colour& paper, bool antialias) {
        return overlay(std::vector{raster({0, 255})}, {{{"", ink}}, paper, Mixing::Cover}, antialias);
    };
    EXPECT_TRUE(image(kBlack, kWhite, false).is_bilevel());
    EXPECT_TRUE(image(kWhite, kBlack, false).is_bilevel());
    EXPECT_FALSE(image(kBlack, kWhite, true).is_bilevel());
    EXPECT_TRUE(image(kBlack, kWhite, true).grey);
    EXPECT_TRUE(image({1, 1, 1}, kWhite, false).grey);
    EXPECT_FALSE(image({1, 1, 1}, kWhite, false).is_bilevel());
    EXPECT_FALSE(image(kWhite, kWhite, false).is_bilevel());
    EXPECT_FALSE(image({0, 0, 255}, kWhite, false).grey);
    EXPECT_FALSE(image(kBlack, {.transparent = true}, false).grey);
}

TEST(Overlay, MultipliesInkWithColouredPaper) {
    const Palette palette{{{"ink", {255, 0, 0}}}, {0, 255, 255}, Mixing::Multiply};
    const auto seen = pixels(overlay(std::vector{raster({0, 255})}, palette, false));
    EXPECT_EQ(seen, (std::vector<Rgba>{{0, 255, 255, 255}, {0, 0, 0, 255}}));
}

TEST(Overlay, IsTransparentWhereTransparentPaperHasNoInk) {
    const Palette palette{{{"a", {255, 0, 0}}, {"b", {0, 0, 255}}}, {.transparent = true}, Mixing::Multiply};
    const std::vector<Raster> inks = {raster({0, 255, 0, 255, 128}), raster({0, 0, 255, 255, 128})};
    const auto binary = pixels(overlay(inks, palette, false));
    EXPECT_EQ(binary[0][3], 0);
    EXPECT_EQ(binary[1], (Rgba{255, 0, 0, 255}));
    EXPECT_EQ(binary[2], (Rgba{0, 0, 255, 255}));
    EXPECT_EQ(binary[3], (Rgba{0, 0, 0, 255}));
    EXPECT_EQ(pixels(overlay(inks, palette, true))[4][3], 192);  // 1 - (127 / 255)^2
}

TEST(Overlay, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const auto picture = overlay(std::vector(4, raster({255})), palette_of("cmyk"), false, source.get_token());
    EXPECT_EQ(picture.pixels, std::vector<std::uint8_t>{0});
}

}  // namespace
}  // namespace ccdt::api

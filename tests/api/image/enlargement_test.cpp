// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/enlargement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "api/input/colour.h"
#include "core/base/thread_executor.h"
#include "core/halftone/dots/softening.h"
#include "core/picture/srgb.h"

namespace ccdt::api {
namespace {

constexpr int kSide = 48;

/// Draws soft dots of a radius of 3 pixels, 8 pixels apart.
Raster dots(int phase) {
    Raster raster{kSide, kSide, 3, std::vector<std::uint8_t>(std::size_t{kSide} * kSide)};
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const double distance = std::hypot((x + phase) % 8 - 3.5, (y + phase) % 8 - 3.5);
            const double share = std::clamp(3.5 - distance, 0.0, 1.0);
            raster.coverage[static_cast<std::size_t>(y * kSide + x)] = static_cast<std::uint8_t>(255 * share + 0.5);
        }
    }
    soften(raster, 2);
    return raster;
}

/// Draws a raster for each ink.
DotImage drawn(const std::vector<Colour>& inks, std::vector<Raster> rasters, const Colour& paper = kWhite) {
    Palette palette{{}, paper, inks.size() > 1 ? Mixing::Multiply : Mixing::Cover};
    for (const Colour& ink : inks) palette.inks.push_back({"", ink});
    return overlay(std::move(rasters), palette, true);
}

/// Returns the encoded value of a channel at a pixel, beyond the border that of the nearest one.
double encoded(const DotImage& picture, int x, int y, std::size_t channel) {
    const auto column = static_cast<std::size_t>(std::clamp(x, 0, picture.width - 1));
    const std::uint8_t* const pixel = picture.row(std::clamp(y, 0, picture.height - 1)) + column * picture.channels();
    return (picture.colours > 0 ? picture.palette[*pixel][channel] : pixel[channel]) / 255.0;
}

/// Returns the mean light of a channel.
double light(const DotImage& picture, std::size_t channel) {
    double sum = 0;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) sum += light_of_srgb(encoded(picture, x, y, channel));
    }
    return sum / (picture.width * picture.height);
}

/// Returns the mean light of a channel at twice the size, interpolated as browsers do.
double enlarged_light(const DotImage& picture, std::size_t channel) {
    double sum = 0;
    for (int y = 0; y < 2 * picture.height; ++y) {
        for (int x = 0; x < 2 * picture.width; ++x) {
            const int own_x = x / 2, own_y = y / 2, side_x = own_x + x % 2 * 2 - 1, side_y = own_y + y % 2 * 2 - 1;
            const double own = 3 * encoded(picture, own_x, own_y, channel) + encoded(picture, side_x, own_y, channel);
            const double side =
                3 * encoded(picture, own_x, side_y, channel) + encoded(picture, side_x, side_y, channel);
            sum += light_of_srgb((3 * own + side) / 16);
        }
    }
    return sum / (4 * picture.width * picture.height);
}

/// @param light_of  light() or enlarged_light()
double luminance(const DotImage& picture, double (&light_of)(const DotImage&, std::size_t)) {
    return luminance_of(light_of(picture, 0), light_of(picture, 1), light_of(picture, 2));
}

TEST(Enlargement, BalancesLuminanceBetweenSizes) {
    const std::vector<std::vector<Colour>> palettes = {
        {kBlack}, {{128, 64, 0}}, {{0, 255, 255}, {255, 0, 255}}, {{224, 32, 32}, {32, 64, 192}}};
    for (const std::vector<Colour>& inks : palettes) {
        std::vector<Raster> rasters = {dots(0), dots(3)};
        rasters.resize(inks.size());
        const DotImage before = drawn(inks, rasters);
        DotImage after = before;
        compensate_enlargement(after);
        const double wanted = luminance(before, light), lost = wanted - luminance(before, enlarged_light);
        EXPECT_GT(lost, 0.005) << hexadecimal(inks.front());
        EXPECT_NEAR(luminance(after, light) - wanted, lost / 2, lost / 8) << hexadecimal(inks.front());
        EXPECT_NEAR(wanted - luminance(after, enlarged_light), lost / 2, lost / 8) << hexadecimal(inks.front());
    }
}

TEST(Enlargement, LightensDotsOfPaper) {
    const DotImage before = drawn({kWhite}, {dots(0)}, kBlack);
    DotImage after = before;
    compensate_enlargement(after);
    EXPECT_GT(light(after, 0), light(before, 0));
    EXPECT_LT(enlarged_light(after, 0), light(before, 0));
}

TEST(Enlargement, LeavesUniformAreasUnchanged) {
    for (const int share : {0, 3, 128, 255}) {
        const Raster even{5, 4, 1, std::vector<std::uint8_t>(20, static_cast<std::uint8_t>(share))};
        DotImage picture = drawn({{32, 64, 96}}, {even});
        const std::vector<std::uint8_t> before = picture.pixels;
        compensate_enlargement(picture);
        EXPECT_EQ(picture.pixels, before);
    }
}

TEST(Enlargement, LeavesTransparentPicturesUnchanged) {
    Colour paper = kWhite;
    paper.transparent = true;
    DotImage picture = drawn({kBlack}, {dots(0)}, paper);
    const std::vector<std::uint8_t> before = picture.pixels;
    compensate_enlargement(picture);
    EXPECT_EQ(picture.pixels, before);
}

TEST(Enlargement, IsSameOnAllExecutors) {
    Raster wide{4000, 40, 1, std::vector<std::uint8_t>(160000)};
    for (std::size_t i = 0; i < wide.coverage.size(); ++i) wide.coverage[i] = static_cast<std::uint8_t>(i * i % 251);
    DotImage one = drawn({kBlack}, {wide}), other = one;
    compensate_enlargement(one);
    ThreadExecutor threads(3);
    compensate_enlargement(other, threads);
    EXPECT_EQ(one.pixels, other.pixels);
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/dither.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/base/thread_executor.h"
#include "core/dither/device_colours.h"
#include "core/dither/direct_search.h"
#include "core/picture/blur.h"
#include "core/picture/tone.h"

namespace ccdt {
namespace {

using Chosen = std::vector<std::uint8_t>;

const std::vector<Light> kBlackAndWhite = {{0, 0, 0}, {1, 1, 1}};
const std::vector<Light> kSixColours = {{0.01f, 0.01f, 0.01f}, {0.8f, 0.8f, 0.8f},    {0.75f, 0.6f, 0.05f},
                                        {0.4f, 0.02f, 0.02f},  {0.02f, 0.08f, 0.45f}, {0.01f, 0.11f, 0.02f}};

std::size_t area(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

LightPlanes flat(float red, float green, float blue, std::size_t pixels) {
    return {std::vector<float>(pixels, red), std::vector<float>(pixels, green), std::vector<float>(pixels, blue)};
}

/// Returns a picture with smooth gradients of grey and colour.
LightPlanes gradients(int width, int height) {
    LightPlanes light = flat(0, 0, 0, area(width, height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
            const double across = static_cast<double>(x) / width, down = static_cast<double>(y) / height;
            light[0][i] = static_cast<float>(across);
            light[1][i] = static_cast<float>(0.5 + 0.4 * std::sin(9 * across) * down);
            light[2][i] = static_cast<float>(down * across);
        }
    }
    return light;
}

Chosen dithered(const LightPlanes& light, int width, int height, const std::vector<Light>& colours,
                Executor& executor = inline_executor()) {
    return dither(light, Chosen(area(width, height), kAnyColour), width, height, colours, 0, {}, executor);
}

/// Returns the root mean square of the difference of two grey pictures, after a blur of 1.5 pixels.
double seen_error(const std::vector<float>& wanted, const Chosen& chosen, int width, int height) {
    std::vector<float> off(wanted.size());
    for (std::size_t i = 0; i < off.size(); ++i) off[i] = static_cast<float>(chosen[i]) - wanted[i];
    off = blurred(off, width, height, 1.5, inline_executor());
    double sum = 0;
    for (const float value : off) sum += static_cast<double>(value) * static_cast<double>(value);
    return std::sqrt(sum / static_cast<double>(off.size()));
}

TEST(Dither, KeepsTheMeanOfFlatGreys) {
    constexpr int kSide = 96;
    for (const float value : {0.01f, 0.05f, 0.2f, 0.5f, 0.77f, 0.98f}) {
        const Chosen chosen = dithered(flat(value, value, value, kSide * kSide), kSide, kSide, kBlackAndWhite);
        const double mean = std::accumulate(chosen.begin(), chosen.end(), 0.0) / (kSide * kSide);
        EXPECT_NEAR(mean, value, 0.0025) << value;
    }
}

TEST(Dither, LooksMoreLikeThePictureThanErrorDiffusion) {
    constexpr int kWidth = 160, kHeight = 120;
    const LightPlanes light = gradients(kWidth, kHeight);
    const std::vector<float>& wanted = light[0];
    const LightPlanes grey = {wanted, wanted, wanted};
    const DeviceColours device(kBlackAndWhite);
    std::vector<DeviceColours::Opponent> opponent;
    for (const float value : wanted) opponent.push_back({value, 0, 0});
    const Chosen given(wanted.size(), kAnyColour);
    const Chosen diffused = diffuse_error(opponent, given, kWidth, kHeight, device);
    const Chosen found = dithered(grey, kWidth, kHeight, kBlackAndWhite);
    constexpr double kGain = 3.7;  // decibels
    EXPECT_LT(seen_error(wanted, found, kWidth, kHeight),
              seen_error(wanted, diffused, kWidth, kHeight) * std::pow(10, -kGain / 20));
}

TEST(Dither, ShowsColoursOfTheDeviceNearlyWithoutOthers) {
    constexpr int kWidth = 40, kHeight = 12;
    // The darkest colour is black and the lightest one white, so that the range is not changed.
    const std::vector<Light> colours = {{0, 0, 0}, {1, 1, 1}, {0.5f, 0, 0}, {0, 0.1f, 0.6f}};
    for (std::size_t number = 0; number < colours.size(); ++number) {
        const Light& colour = colours[number];
        const Chosen chosen =
            dithered(flat(colour.red, colour.green, colour.blue, kWidth * kHeight), kWidth, kHeight, colours);
        // The table of the gamut is not exact at its corners.
        EXPECT_GE(std::ranges::count(chosen, number), 0.95 * kWidth * kHeight) << number;
    }
}

TEST(Dither, MapsBlackAndWhiteToTheRangeOfTheDevice) {
    constexpr int kSide = 16;
    for (const float value : {0.0f, 1.0f}) {
        const Chosen chosen = dithered(flat(value, value, value, kSide * kSide), kSide, kSide, kSixColours);
        EXPECT_TRUE(std::ranges::all_of(chosen, [&](std::uint8_t each) { return each == (value > 0 ? 1 : 0); }));
    }
}

TEST(Dither, KeepsGivenPixels) {
    constexpr int kWidth = 64, kHeight = 48;
    const LightPlanes light = gradients(kWidth, kHeight);
    Chosen given(area(kWidth, kHeight), kAnyColour);
    for (std::size_t i = 0; i < given.size(); i += 3) given[i] = static_cast<std::uint8_t>(i / 3 % kSixColours.size());
    const Chosen chosen = dither(light, given, kWidth, kHeight, kSixColours);
    for (std::size_t i = 0; i < given.size(); i += 3) ASSERT_EQ(chosen[i], given[i]) << i;
}

TEST(Dither, GivesTheSameResultOnAnyNumberOfThreads) {
    // More tiles of the search than threads, and sides that are not multiples of any block.
    constexpr int kWidth = 413, kHeight = 301;
    const LightPlanes light = gradients(kWidth, kHeight);
    for (const auto& colours : {kBlackAndWhite, kSixColours}) {
        const Chosen expected = dithered(light, kWidth, kHeight, colours);
        for (const std::size_t threads : {2, 5}) {
            ThreadExecutor executor(threads);
            EXPECT_EQ(dithered(light, kWidth, kHeight, colours, executor), expected) << threads << " threads";
        }
    }
}

TEST(Dither, PrintsSpotsOfTheDarkerColour) {
    constexpr int kSide = 48;
    const std::vector<Light> blue_first = {{0.1f, 0.1f, 0.6f}, {0.9f, 0.8f, 0.7f}};
    const LightPlanes light = gradients(kSide, kSide);
    const Chosen given(kSide * kSide, kAnyColour);
    const Chosen chosen = dither(light, given, kSide, kSide, blue_first, 1.5);
    Chosen reverse = dither(light, given, kSide, kSide, std::vector<Light>{blue_first[1], blue_first[0]}, 1.5);
    for (std::uint8_t& pixel : reverse) pixel = static_cast<std::uint8_t>(1 - pixel);
    EXPECT_EQ(chosen, reverse);
    const Chosen squares = dither(light, given, kSide, kSide, blue_first);
    EXPECT_LT(std::ranges::count(chosen, 0), 0.8 * static_cast<double>(std::ranges::count(squares, 0)));
}

TEST(Dither, MapsBlackToTheDarkestPrint) {
    constexpr int kSide = 16;
    const LightPlanes black = flat(0, 0, 0, kSide * kSide);
    for (const double diameter : {1.0, 1.3}) {  // there are gaps between spots
        const Chosen chosen = dither(black, Chosen(kSide * kSide, kAnyColour), kSide, kSide, kBlackAndWhite, diameter);
        EXPECT_EQ(std::ranges::count(chosen, 0), kSide * kSide) << diameter;
    }
}

TEST(Dither, AcceptsThinPictures) {
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 300}, {300, 1}, {2, 2}, {9, 3}}) {
        const Chosen chosen = dithered(gradients(width, height), width, height, kSixColours);
        EXPECT_EQ(chosen.size(), area(width, height));
        EXPECT_LT(std::ranges::max(chosen), kSixColours.size());
    }
}

TEST(Dither, AcceptsValuesOutsideTheRange) {
    constexpr int kSide = 8;
    const Chosen chosen = dithered(flat(1e30f, -1e30f, 2, kSide * kSide), kSide, kSide, kSixColours);
    EXPECT_LT(std::ranges::max(chosen), kSixColours.size());
}

TEST(Dither, StopsEarly) {
    constexpr int kSide = 64;
    std::stop_source source;
    source.request_stop();
    const LightPlanes light = gradients(kSide, kSide);
    const Chosen chosen =
        dither(light, Chosen(kSide * kSide, kAnyColour), kSide, kSide, kSixColours, 0, source.get_token());
    EXPECT_NE(chosen, dithered(light, kSide, kSide, kSixColours));
}

TEST(DirectSearch, KeepsAPictureThatNoChangeImproves) {
    constexpr int kWidth = 70, kHeight = 50;
    const DeviceColours device(kSixColours);
    const LightPlanes light = gradients(kWidth, kHeight);
    std::vector<DeviceColours::Opponent> wanted;
    for (std::size_t i = 0; i < light[0].size(); ++i)
        wanted.push_back(DeviceColours::opponent({light[0][i], light[1][i], light[2][i]}));
    const Chosen given(wanted.size(), kAnyColour);
    Chosen chosen(wanted.size(), 0);
    // The search ends when few pixels change, so it is called until none does.
    constexpr int kMaxCalls = 20;
    for (int call = 0; call < kMaxCalls; ++call) {
        Chosen next = search_directly(wanted, given, chosen, kWidth, kHeight, device);
        if (next == chosen) return;
        chosen = std::move(next);
    }
    FAIL() << "still changes after " << kMaxCalls << " calls";
}

}  // namespace
}  // namespace ccdt

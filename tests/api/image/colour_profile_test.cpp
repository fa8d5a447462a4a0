// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/colour_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "api/image/image_header.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

std::string profile_in(const std::string& name) {
    const std::string file = fixture(name);
    return read_colour_tags(file, *recognise_image(file)).profile;
}

std::optional<ColourConversion> convert(std::string profile) {
    return convert_colours({std::move(profile), {}, {}});
}

/// Calculated by hand from the primaries of Display P3 and ITU-R BT.709.
constexpr LightMatrix kP3ToSrgb = {
    {{1.2249F, -0.2249F, 0.0F}, {-0.0420F, 1.0420F, 0.0F}, {-0.0196F, -0.0786F, 1.0983F}}};

void expect_p3(const std::optional<ColourConversion>& conversion, const std::string& name) {
    ASSERT_TRUE(conversion && conversion->matrix) << name;
    EXPECT_FALSE(conversion->transform) << name;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR((*conversion->matrix)[i][j], kP3ToSrgb[i][j], 0.001F) << name;
    }
}

TEST(ColourProfile, ReadsPrimariesFromProfilesChromaticitiesAndCodePoints) {
    expect_p3(convert(profile_in("p3.png")), "profile");
    for (const auto* name : {"p3-chromaticities.png", "p3-code-points.png"}) {
        const std::string file = fixture(name);
        expect_p3(convert_colours(read_colour_tags(file, ImageFormat::Png)), name);
    }
}

TEST(ColourProfile, ReadsTheCurvesAndPrimariesOfCodePoints) {
    const auto light = [](std::uint8_t primaries, std::uint8_t transfer, float share) {
        return convert_colours({{}, ColourTags::CodePoints{primaries, transfer}, {}})->curves.front()(share);
    };
    EXPECT_NEAR(light(1, 5, 0.5F), std::pow(0.5F, 2.8F), 1e-4);
    EXPECT_NEAR(light(1, 7, 0.05F), 0.0125F, 1e-4);
    EXPECT_NEAR(light(1, 7, 0.5F), std::pow(0.6115F / 1.1115F, 1 / 0.45F), 1e-4);
    EXPECT_NEAR(light(11, 17, 0.5F), 52.37F / 48 * std::pow(0.5F, 2.6F), 1e-4);
    EXPECT_EQ(light(11, 17, 1), 1);
    for (const std::uint8_t primaries : std::array<std::uint8_t, 9>{4, 5, 6, 7, 8, 9, 11, 12, 22}) {
        EXPECT_EQ(light(primaries, 8, 0.5F), 0.5F) << int{primaries};
        EXPECT_TRUE(convert_colours({{}, ColourTags::CodePoints{primaries, 13}, {}})->matrix) << int{primaries};
    }
}

TEST(ColourProfile, ConvertsNothingForSrgb) {
    EXPECT_FALSE(convert(profile_in("srgb.png")));
    EXPECT_FALSE(convert_colours({{}, ColourTags::CodePoints{1, 13}, {}}));
    EXPECT_FALSE(convert_colours({{}, {}, std::array{0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06}}));
    EXPECT_FALSE(convert_colours({}));
}

TEST(ColourProfile, ReadsTheCurveOfAGreyProfile) {
    const auto conversion = convert(profile_in("ramp-gamma.png"));
    ASSERT_TRUE(conversion);
    EXPECT_EQ(conversion->space, ColourConversion::Space::Grey);
    ASSERT_EQ(conversion->curves.size(), 1U);
    const float gamma = 461.0F / 256;  // 1.8 as stored in profiles
    for (const float share : {0.0F, 0.01F, 0.2F, 0.5F, 0.9F, 1.0F})
        EXPECT_NEAR(conversion->curves[0](share), std::pow(share, gamma), 1e-4) << share;
}

TEST(ColourProfile, AppliesTheCurveOfAnRgbProfileToGrey) {
    EXPECT_FALSE(convert(profile_in("p3.png"))->grey) << "the curve is that of sRGB";
    std::string profile = profile_in("p3.png");
    const std::string power("curv\0\0\0\0\0\0\0\1\1\xcd", 14);  // with an exponent of 461 / 256
    for (std::size_t at = 0; (at = profile.find("curv", at)) != std::string::npos; at += power.size())
        profile.replace(at, power.size(), power);
    EXPECT_NEAR(convert(profile)->grey(0.5F), std::pow(0.5F, 461.0F / 256), 1e-4);
}

/// Converts a colour of high dynamic range to light with the primaries of the file.
std::array<float, 3> compressed(std::uint8_t transfer, std::array<float, 3> shares) {
    const auto conversion = convert_colours({{}, ColourTags::CodePoints{9, transfer}, {}});
    std::array<std::uint16_t, 3> from{}, to{};
    for (std::size_t i = 0; i < 3; ++i) from[i] = static_cast<std::uint16_t>(std::lround(shares[i] * 65535));
    conversion->transform(from.data(), to.data(), 1);
    std::array<float, 3> light{};
    for (std::size_t i = 0; i < 3; ++i) light[i] = conversion->curves[i](static_cast<float>(to[i]) / 65535);
    return light;
}

TEST(ColourProfile, CompressesHighDynamicRange) {
    constexpr std::uint8_t kPq = 16, kHlg = 18;
    // By ITU-R BT.2408, white is at 58 % in PQ and at 75 % in HLG. In PQ, 1,000 cd/m2 are at 75 %.
    EXPECT_NEAR(compressed(kPq, {0.581F, 0.581F, 0.581F})[0], 0.52F, 0.005F);
    EXPECT_NEAR(compressed(kPq, {0.752F, 0.752F, 0.752F})[0], 1, 0.005F);
    EXPECT_EQ(compressed(kPq, {1, 1, 1})[0], 1);
    EXPECT_EQ(compressed(kPq, {0, 0, 0})[0], 0);
    EXPECT_NEAR(compressed(kHlg, {0.75F, 0.75F, 0.75F})[0], 0.52F, 0.005F);
    EXPECT_NEAR(compressed(kHlg, {1, 1, 1})[0], 1, 1e-3);
    EXPECT_EQ(compressed(kHlg, {0, 0, 0})[0], 0);
    const auto red = compressed(kPq, {0.75F, 0.58F, 0.4F});
    EXPECT_NEAR(red[0], 1, 0.01F);
    EXPECT_NEAR(red[1] / red[0], 202.0F / 983, 0.01F) << "ratios are kept";
    for (const std::uint8_t transfer : {kPq, kHlg}) {
        const auto grey = convert_colours({{}, ColourTags::CodePoints{9, transfer}, {}})->grey;
        float last = -1;
        for (const float share : {0.0F, 0.1F, 0.3F, 0.5F, 0.6F, 0.7F, 0.75F}) {
            EXPECT_NEAR(grey(share), compressed(transfer, {share, share, share})[2], 1e-3) << share;
            EXPECT_GT(grey(share), last);
            last = grey(share);
        }
    }
}

TEST(ColourProfile, TakesUnspecifiedPrimariesAsThoseOfSrgb) {
    const auto conversion = convert_colours({{}, ColourTags::CodePoints{2, 16}, {}});
    ASSERT_TRUE(conversion);
    EXPECT_TRUE(conversion->transform);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR((*conversion->matrix)[i][i], 1, 1e-3);
}

TEST(ColourProfile, UsesTheProfileInsteadOfUnsupportedCodePoints) {
    const ColourTags tags{profile_in("p3.png"), ColourTags::CodePoints{9, 9}, {}};  // logarithmic
    expect_p3(convert_colours(tags), "profile");
}

TEST(ColourProfile, IgnoresBrokenProfiles) {
    EXPECT_FALSE(convert("acsp"));
    EXPECT_FALSE(convert(std::string(5000, '\xff')));
    for (const auto* name : {"p3.png", "inks.tif", "ramp-gamma.png"}) {
        const std::string profile = profile_in(name);
        for (std::size_t size = 1; size < profile.size(); size += 1 + profile.size() / 30)
            static_cast<void>(convert(profile.substr(0, size)));
    }
}

TEST(ColourProfile, ReturnsValidLightForDamagedProfiles) {
    std::mt19937 random(7);
    for (const auto* name : {"p3.png", "inks.tif", "ramp-gamma.png"}) {
        const std::string profile = profile_in(name);
        for (int round = 0; round < 40; ++round) {
            std::string damaged = profile;
            const std::size_t most = std::min<std::size_t>(damaged.size(), 600);
            for (unsigned i = 0; i < 1 + random() % 4; ++i)
                damaged[128 + random() % (most - 128)] = static_cast<char>(random() % 256);
            const auto conversion = convert(damaged);
            if (!conversion) continue;
            for (const auto& curve : conversion->curves) {
                for (const float share : {0.0F, 0.3F, 1.0F}) ASSERT_TRUE(curve(share) >= 0 && curve(share) <= 1);
            }
            if (conversion->matrix) {
                for (const auto& row : *conversion->matrix) ASSERT_NEAR(row[0] + row[1] + row[2], 1, 1e-3);
            }
        }
    }
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/colour_tags.h"

#include <gtest/gtest.h>

#include <string>

#include "api/image/image_codec.h"
#include "api/image/image_header.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

ColourTags tags_of(std::string_view file) {
    return read_colour_tags(file, *recognise_image(file));
}

std::string hidden(std::string_view file) {
    return hide_profile(file, *recognise_image(file));
}

bool is_profile(std::string_view bytes) {
    return bytes.size() > 128 && bytes.substr(36, 4) == "acsp";
}

TEST(ColourTags, FindsTheProfileInEveryFormat) {
    const std::string profile = tags_of(fixture("p3.png")).profile;
    EXPECT_TRUE(is_profile(profile));
    EXPECT_EQ(tags_of(fixture("p3.webp")).profile, profile);
    EXPECT_EQ(tags_of(fixture("p3.tif")).profile, profile);
    EXPECT_EQ(tags_of(fixture("p3.avif")).profile, profile);
    const std::string in_two_segments = tags_of(fixture("p3.jpg")).profile;
    EXPECT_GT(in_two_segments.size(), 65535U);
    EXPECT_TRUE(in_two_segments.starts_with(profile));
    for (const auto* name : {"palette.png", "grey.jpg", "lossy.webp", "lzw.tif", "big-endian.tif", "lossless.avif"}) {
        EXPECT_TRUE(tags_of(fixture(name)).profile.empty()) << name;
        EXPECT_EQ(hidden(fixture(name)), "") << name;
    }
}

TEST(ColourTags, ReadsChromaticitiesAndCodePointsOfPngs) {
    const auto tags = tags_of(fixture("p3-chromaticities.png"));
    ASSERT_TRUE(tags.primaries);
    EXPECT_NEAR((*tags.primaries)[0], 0.3127, 1e-9);
    EXPECT_NEAR((*tags.primaries)[7], 0.060, 1e-9);
    const auto code = tags_of(fixture("p3-code-points.png")).code_points;
    ASSERT_TRUE(code);
    EXPECT_EQ(code->primaries, 12);
    EXPECT_EQ(code->transfer, 13);
}

TEST(ColourTags, ReadsCodePointsOfAnAvifWithoutAProfile) {
    const auto code = tags_of(fixture("p3-code-points.avif")).code_points;
    ASSERT_TRUE(code);
    EXPECT_EQ(code->primaries, 12);
    EXPECT_EQ(code->transfer, 13);
    EXPECT_FALSE(tags_of(fixture("p3.avif")).code_points);
}

TEST(ColourTags, HidesOnlyTheProfile) {
    for (const auto* name : {"p3.png", "p3.jpg"}) {
        const std::string file = fixture(name);
        const std::string bare = hidden(file);
        ASSERT_FALSE(bare.empty()) << name;
        EXPECT_FALSE(may_have_profile(bare, *recognise_image(bare))) << name;
        EXPECT_TRUE(tags_of(bare).profile.empty()) << name;
        const auto picture = decode_image(bare, 10'000);
        ASSERT_TRUE(picture) << name << ": " << picture.error().message;
        EXPECT_EQ(picture->width, decode_image(file, 10'000)->width) << name;
    }
}

TEST(ColourTags, IgnoresAProfileWithAMissingSegment) {
    const std::string file = fixture("p3.jpg");
    const std::size_t second = file.rfind("ICC_PROFILE");
    ASSERT_NE(second, file.find("ICC_PROFILE"));
    for (const char number : {'\0', '\1', '\3'}) {
        std::string damaged = file;
        damaged[second + 12] = number;
        EXPECT_TRUE(tags_of(damaged).profile.empty()) << int{number};
        EXPECT_TRUE(decode_image(damaged, 10'000)) << int{number};
    }
}

TEST(ColourTags, SurvivesFilesTruncatedAnywhere) {
    for (const auto* name : {"p3.png", "p3.webp", "p3.tif", "inks.jpg", "p3-code-points.png"}) {
        const std::string file = fixture(name);
        for (std::size_t size = 12; size < file.size(); ++size) {
            const auto part = std::string_view(file).substr(0, size);
            EXPECT_LE(tags_of(part).profile.size(), kLongestProfile) << name << ' ' << size;
            EXPECT_LE(hidden(part).size(), size) << name;
        }
    }
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/negotiation.h"

#include <gtest/gtest.h>

#include <array>

namespace ccdt::api {
namespace {

constexpr std::array<const FileFormat*, 2> kMade = {&kPng, &kJson};

TEST(Negotiation, FollowsTheAcceptHeader) {
    EXPECT_EQ(kMade[*negotiate("application/json", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/png", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("image/*", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("APPLICATION/Json; charset=utf-8", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("text/html, application/*", kMade)], &kJson);
}

TEST(Negotiation, BreaksTiesInTheServersOrder) {
    EXPECT_EQ(kMade[*negotiate("", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("*/*", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("application/json, image/png", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("text/html,application/xhtml+xml,application/xml;q=0.9,image/webp,*/*;q=0.8", kMade)],
              &kPng);
}

TEST(Negotiation, ComparesQualities) {
    EXPECT_EQ(kMade[*negotiate("image/png;q=0.5, application/json;q=0.6", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/png ; Q=0.5 , */* ; q=0.501", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/png;level=1;q=0.2,*/*;q=0.1", kMade)], &kPng);
}

TEST(Negotiation, UsesTheMostSpecificRange) {
    EXPECT_EQ(kMade[*negotiate("*/*, image/png;q=0.1", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/*;q=0, */*", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/*;q=0.1, image/png, application/json;q=0.9", kMade)], &kPng);
}

TEST(Negotiation, RefusesUnacceptableMediaTypes) {
    for (const auto* accept :
         {"text/html", "image/webp", "*/*;q=0", "image/png;q=0, application/json;q=0.0", "text/*"}) {
        const auto chosen = negotiate(accept, kMade);
        ASSERT_FALSE(chosen) << accept;
        EXPECT_EQ(chosen.error().code, ErrorCode::NotAcceptable);
        EXPECT_NE(chosen.error().message.find("image/png, application/json"), std::string::npos);
    }
}

TEST(Negotiation, IgnoresInvalidMediaRanges) {
    EXPECT_EQ(kMade[*negotiate("garbage", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate(",,,;;;", kMade)], &kPng);
    EXPECT_EQ(kMade[*negotiate("image/png;q=2, application/json", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("image/png;q=nan, application/json", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("*/png, application/json", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("text/x;a=\"image/png,\\\"\", application/json", kMade)], &kJson);
    EXPECT_EQ(kMade[*negotiate("application/json;a=\"unclosed", kMade)], &kJson);
}

TEST(Format, IsChosenByName) {
    EXPECT_EQ(kMade[*read_format({"format", "format", "json"}, kMade)], &kJson);
    const auto svg = read_format({"format", "format", "svg"}, kMade);
    ASSERT_FALSE(svg);
    EXPECT_EQ(svg.error().code, ErrorCode::Malformed);
    EXPECT_EQ(svg.error().field, "format");
    EXPECT_EQ(svg.error().message, "format 'svg' is not available here; the formats are png, json");
}

TEST(Negotiation, FindsFormatsBySuffix) {
    static constexpr FileFormat kPlot{"hpgl", "HPGL", "plt", "application/vnd.hp-hpgl", ""};
    static constexpr FileFormat kTiff{"tiff", "TIFF", "tiff", "image/tiff", ""};
    static constexpr std::array<const FileFormat*, 4> kFiles = {&kPng, &kPlot, &kTiff, &kJson};
    EXPECT_EQ(format_of_suffix(".png", kFiles), 0U);
    EXPECT_EQ(format_of_suffix(".PLT", kFiles), 1U);
    EXPECT_EQ(format_of_suffix(".hpgl", kFiles), 1U);
    EXPECT_EQ(format_of_suffix(".Tif", kFiles), 2U);
    for (const auto* suffix : {"", ".", "png", ".pn", ".pngs"}) {
        const auto found = format_of_suffix(suffix, kFiles);
        ASSERT_FALSE(found) << suffix;
        EXPECT_EQ(found.error().message, "the suffix names no format; it must be one of .png, .plt, .tiff, .json");
    }
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/colour.h"

#include <gtest/gtest.h>

namespace ccdt::api {
namespace {

Input text(std::string_view value) {
    return {"background", "background", value};
}

TEST(Colour, ReadsShortAndLongForms) {
    EXPECT_EQ(*read_colour(text("#fa0")), (Colour{255, 170, 0}));
    EXPECT_EQ(*read_colour(text("#01Fe7f")), (Colour{1, 254, 127}));
}

TEST(Colour, ReadsNamesOfCss) {
    EXPECT_EQ(*read_colour(text("aliceblue")), (Colour{240, 248, 255}));
    EXPECT_EQ(*read_colour(text("teal")), (Colour{0, 128, 128}));
    EXPECT_EQ(*read_colour(text("yellowgreen")), (Colour{154, 205, 50}));
    const auto wrong = read_colour(text("rebecca"));
    EXPECT_EQ(wrong.error().message, "background must be a colour: #rgb, #rrggbb or a name of CSS such as teal");
    EXPECT_NE(read_colour(text("")).error().message.find("in a URL, # is written %23"), std::string::npos);
}

TEST(Colour, RefusesInvalidColours) {
    for (const auto* wrong : {"", "#", "fa0", "#fa", "#fa00", "#ggg", "#-10", "#12345", "#1234567", "reds", "Red",
                              "f0f8ff", " ", "#12 456"}) {
        const auto colour = read_colour(text(wrong));
        ASSERT_FALSE(colour) << wrong;
        EXPECT_EQ(colour.error().code, ErrorCode::Malformed);
        EXPECT_EQ(colour.error().field, "background");
    }
}

TEST(Colour, AcceptsTransparentOnlyWhereAllowed) {
    EXPECT_FALSE(read_colour(text("transparent")));
    EXPECT_TRUE(read_colour_or_none(text("transparent"))->transparent);
    EXPECT_EQ(*read_colour_or_none(text("#fff")), kWhite);
}

}  // namespace
}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/palette.h"

#include <gtest/gtest.h>

#include "api/image/ink_set.h"
#include "tests/support/inks.h"

namespace ccdt::api {
namespace {

Input text(std::string_view value) {
    return {"palette", "palette", value};
}

std::vector<std::string> names_of(const Palette& palette) {
    std::vector<std::string> names;
    for (const auto& ink : palette.inks) names.push_back(ink.name);
    return names;
}

void expect_refused(const Input& input, const std::string& message, const std::string& field) {
    const auto palette = read_palette(input);
    ASSERT_FALSE(palette) << message;
    EXPECT_EQ(palette.error().code, ErrorCode::Malformed);
    EXPECT_EQ(palette.error().field, field);
    EXPECT_NE(palette.error().message.find(message), std::string::npos) << palette.error().message;
}

TEST(Palette, HasTheInksOfCore) {
    const auto cmyk = read_color({"color", "color", "cmyk"});
    const auto rgb = read_color({"color", "color", "rgb"});
    ASSERT_TRUE(cmyk && rgb);
    EXPECT_EQ(names_of(*cmyk), (std::vector<std::string>{"cyan", "magenta", "yellow", "black"}));
    EXPECT_EQ(names_of(*rgb), (std::vector<std::string>{"red", "green", "blue"}));
    for (const auto& [palette, inks] : {std::pair{*cmyk, test::cmyk_inks()}, std::pair{*rgb, test::rgb_inks()}}) {
        const InkSet set = ink_set(palette);
        EXPECT_EQ(set.inks, inks.inks);
        EXPECT_EQ(set.paper, inks.paper);
        EXPECT_EQ(set.additive, inks.additive);
    }
}

TEST(Palette, HasOneOpaqueInkForGrey) {
    const auto grey = read_color({"color", "color", "gray"});
    ASSERT_TRUE(grey);
    EXPECT_EQ(names_of(*grey), std::vector<std::string>{""});
    EXPECT_EQ(grey->inks.front().colour, kBlack);
    EXPECT_EQ(grey->paper, kWhite);
    EXPECT_EQ(grey->mixing, Mixing::Cover);
    EXPECT_FALSE(read_color({"color", "color", "grey"}));
}

TEST(Palette, IsReadFromText) {
    const auto palette = read_palette(text("#F00, #123456 ,#000"));
    ASSERT_TRUE(palette) << palette.error().message;
    EXPECT_EQ(names_of(*palette), (std::vector<std::string>{"#ff0000", "#123456", "#000000"}));
    EXPECT_EQ(palette->inks[1].colour, (Colour{0x12, 0x34, 0x56}));
    EXPECT_EQ(palette->paper, kWhite);
    EXPECT_EQ(palette->mixing, Mixing::Multiply);
    EXPECT_EQ(read_palette(text("#000,#111,#222,#333,#444,#555"))->inks.size(), 6U);
}

TEST(Palette, IsReadFromJson) {
    const auto document = JsonDocument::parse(R"([["#f00","#00f"],"#f00,#00f",[],["#f00","reds"],["#f00","#ff0000"],[7],
                                                  7,["#000","#111","#222","#333","#444","#555","#666"]])");
    std::vector<JsonValue> values;
    for (const JsonValue value : document->root()) values.push_back(value);
    const auto input = [&](std::size_t i) { return Input{"palette", "/palette", values[i]}; };
    EXPECT_EQ(names_of(*read_palette(input(0))), (std::vector<std::string>{"#ff0000", "#0000ff"}));
    EXPECT_EQ(names_of(*read_palette(input(1))), (std::vector<std::string>{"#ff0000", "#0000ff"}));
    expect_refused(input(2), "must have 1 to 6 colours", "/palette");
    expect_refused(input(3), "/palette/1 must be a colour", "/palette/1");
    expect_refused(input(4), "repeats an earlier colour: #ff0000", "/palette/1");
    expect_refused(input(5), "/palette/0 must be a string", "/palette/0");
    expect_refused(input(6), "must be a string or an array", "/palette");
    expect_refused(input(7), "must have 1 to 6 colours", "/palette");
}

TEST(Palette, IsRefusedWithTheFieldOfTheError) {
    expect_refused(text(""), "must have 1 to 6 colours", "palette");
    expect_refused(text("#000,#111,#222,#333,#444,#555,#666"), "must have 1 to 6 colours", "palette");
    expect_refused(text("#000,"), "colour 2 must be a colour: #rgb, #rrggbb", "palette");
    expect_refused(text("#000,transparent"), "colour 2 must be a colour", "palette");
    expect_refused(text("#abc,#000,#aabbcc"), "colour 3 repeats an earlier colour: #aabbcc", "palette");
}

}  // namespace
}  // namespace ccdt::api

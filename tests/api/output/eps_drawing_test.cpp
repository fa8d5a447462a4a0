// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/eps_drawing.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

/// Draws two dots of an ink and one dot of another, with a radius of 0.5 mm, on a page of 100 mm x 50 mm.
std::string written(const std::vector<Ink>& inks, Mixing mixing, const DrawingOptions& drawing) {
    Distribution two, one;
    two.points = {{1, 1}, {3, 1.25}};
    one.points = {{0.01, 5}};
    std::vector<InkDots> layers = {{inks[0], two, 0.05}};
    if (inks.size() > 1) layers.push_back({inks[1], one, 0.05});
    const Palette palette{inks, kWhite, mixing};
    const Page page{{{0, 0}, {10, 5}}, false, false, {10, 5, 1}, 100};
    return test::whole_body([&](Body& body) { write_eps({layers}, palette, page, drawing, body, {}, {}); });
}

/// Returns the part of a document after the operators that it defines.
std::string drawn(const std::string& document) {
    return document.substr(document.find("setlinejoin\n") + 12);
}

TEST(Eps, StatesItsSizeInPoints) {
    const std::string document = written({{}}, Mixing::Cover, {});
    EXPECT_TRUE(
        document.starts_with("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 284 142\n"
                             "%%HiResBoundingBox: 0 0 283.465 141.732\n%%LanguageLevel: 2\n%%EndComments\n"))
        << document;
}

TEST(Eps, DrawsDiscsOnPaper) {
    EXPECT_EQ(drawn(written({{"", {255, 0, 51}}}, Mixing::Cover, {})),
              "0 0 m\n100 0 l\n100 50 l\n0 50 l\nh\n1 1 1 rg f\n"
              "10 10 0.5 d\n30 12.5 0.5 d\n1 0 0.2 rg f\n"
              "grestore end showpage\n%%EOF\n");
}

TEST(Eps, DrawsTheStrokesOfPens) {
    EXPECT_EQ(drawn(written({{}}, Mixing::Cover, {.style = DotStyle::Path})),
              "10 10 m\n10 10 l\n30 12.5 l\n0 0 0 rg 0.3 S\ngrestore end showpage\n%%EOF\n");
}

TEST(Eps, OverprintsInksThatMix) {
    const std::string document =
        drawn(written({{"cyan", {0, 255, 255}}, {"All", {255, 0, 0}}}, Mixing::Multiply, {.style = DotStyle::Stroke}));
    EXPECT_EQ(document,
              "[/Separation(Cyan)cvn/DeviceRGB{dup 1 mul 1 exch sub exch dup 0 mul 1 exch sub exch 0 mul 1 exch "
              "sub}]setcolorspace 1 setcolor true setoverprint\n"
              "10 10 m\n10 10 l\n30 12.5 m\n30 12.5 l\n1 S\nfalse setoverprint\n"
              "[/Separation(All ink)cvn/DeviceRGB{dup 0 mul 1 exch sub exch dup 1 mul 1 exch sub exch 1 mul 1 exch "
              "sub}]setcolorspace 1 setcolor true setoverprint\n"
              "0.1 50 m\n0.1 50 l\n1 S\nfalse setoverprint\ngrestore end showpage\n%%EOF\n");
}

TEST(Eps, EscapesNamesOfInks) {
    const std::string document = written({{"a(b)\\", {}}, {"c", {}}}, Mixing::Multiply, {});
    EXPECT_NE(document.find("[/Separation(A\\(b\\)\\\\)cvn"), std::string::npos) << document;
}

}  // namespace
}  // namespace ccdt::api

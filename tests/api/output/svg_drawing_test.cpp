// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_drawing.h"

#include <gtest/gtest.h>

#include <array>

namespace ccdt::api {
namespace {

/// Returns the part of the document after the white background.
std::string drawn(SvgDrawing& svg) {
    const std::string text = svg.finish();
    const auto start = text.find("/>\n") + 3;
    return text.substr(start, text.rfind("</svg>") - start);
}

TEST(SvgDrawing, HasWhiteBackground) {
    EXPECT_EQ(SvgDrawing(30, 20).finish(),
              "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"30\" height=\"20\" viewBox=\"0 0 30 20\" "
              "font-family=\"DejaVu Sans, Verdana, sans-serif\">\n"
              "<rect x=\"0\" y=\"0\" width=\"30\" height=\"20\" fill=\"#fff\"/>\n"
              "</svg>\n");
}

TEST(SvgDrawing, RoundsToTwoDecimals) {
    SvgDrawing svg(9, 9);
    svg.line({1.0 / 3, -0.001}, {123456.789, 1e-9}, "stroke=\"#000\"");
    EXPECT_EQ(drawn(svg), "<line x1=\"0.33\" y1=\"0\" x2=\"123456.79\" y2=\"0\" stroke=\"#000\"/>\n");
}

TEST(SvgDrawing, DrawsShapes) {
    SvgDrawing svg(9, 9);
    const std::array<Point, 2> points = {Point{1, 2}, Point{3.5, 4}};
    svg.polyline(points, "fill=\"none\"");
    svg.rectangle({{1, 2}, {4, 8}}, "fill=\"none\"");
    svg.dots(points, 1.5);
    EXPECT_EQ(drawn(svg),
              "<polyline points=\"1,2 3.5,4 \" fill=\"none\"/>\n"
              "<rect x=\"1\" y=\"2\" width=\"3\" height=\"6\" fill=\"none\"/>\n"
              "<path stroke=\"#000\" stroke-linecap=\"round\" stroke-width=\"3\" d=\"M1 2h0M3.5 4h0\"/>\n");
}

TEST(SvgDrawing, WritesText) {
    SvgDrawing svg(9, 9);
    svg.text({1, 2}, Anchor::Start, 12, "a");
    svg.text({1, 2}, Anchor::Middle, 12, "b");
    svg.text({1, 2}, Anchor::End, 12, "c");
    EXPECT_EQ(drawn(svg),
              "<text x=\"1\" y=\"2\" font-size=\"12\" text-anchor=\"start\">a</text>\n"
              "<text x=\"1\" y=\"2\" font-size=\"12\" text-anchor=\"middle\">b</text>\n"
              "<text x=\"1\" y=\"2\" font-size=\"12\" text-anchor=\"end\">c</text>\n");
}

TEST(SvgDrawing, EmbedsPicturesOfAnyLength) {
    // RFC 4648, section 10.
    for (const auto& [bytes, text] : {std::pair{"", "\"/>"}, std::pair{"f", "Zg==\"/>"}, std::pair{"fo", "Zm8=\"/>"},
                                      std::pair{"foo", "Zm9v\"/>"}, std::pair{"foob", "Zm9vYg==\"/>"}}) {
        SvgDrawing svg(9, 9);
        svg.picture({{0, 0}, {1, 1}}, bytes);
        EXPECT_NE(drawn(svg).find(std::string("href=\"data:image/png;base64,") + text), std::string::npos) << bytes;
    }
}

TEST(SvgDrawing, ClipsWithoutMovingCoordinates) {
    SvgDrawing svg(9, 9);
    svg.begin_clip({{1, 2}, {4, 8}});
    svg.end_clip();
    EXPECT_EQ(drawn(svg), "<svg x=\"1\" y=\"2\" width=\"3\" height=\"6\" viewBox=\"1 2 3 6\">\n</svg>\n");
}

}  // namespace
}  // namespace ccdt::api

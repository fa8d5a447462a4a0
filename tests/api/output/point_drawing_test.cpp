// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

const std::vector<Point> kPoints = {{11, 21}, {19, 21}, {12.34567891, 24}};
const Box kBox = {{10, 20}, {20, 25}};

Page page(std::optional<double> width_mm = {}) {
    return {kBox, true, false, canvas_of(kBox, 4), width_mm};
}

Distribution dots_at(std::vector<Point> points) {
    Distribution dots;
    dots.points = std::move(points);
    return dots;
}

/// Draws dots of one ink without a name.
std::string svg_of(const std::vector<Point>& points, const Page& page, double radius, DotStyle style,
                   const Palette& palette = {}, const std::stop_token& path_stop = {},
                   const std::stop_token& stop = {}) {
    const Distribution dots = dots_at(points);
    const InkDots ink{palette.inks.front(), dots, radius};
    return test::whole_body([&](Body& body) {
        write_svg({{&ink, 1}}, palette, page, {.style = style}, body, path_stop, stop);
    });
}

std::stop_token stopped_token() {
    std::stop_source source;
    source.request_stop();
    return source.get_token();
}

double mean(const Raster& raster) {
    return std::accumulate(raster.coverage.begin(), raster.coverage.end(), 0.0) / 255 /
           static_cast<double>(raster.coverage.size());
}

TEST(Svg, DrawsDiscsRelativeToUpperLeftCorner) {
    EXPECT_EQ(svg_of(kPoints, page(), 0.5, DotStyle::Fill),
              R"(<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20" viewBox="0 0 10 5">
<desc>3 dots along a path of 10.5873; in their original order it is 15.29931; their radius is 0.5</desc>
<rect width="10" height="5" fill="#ffffff"/>
<g fill="#000000">
<circle cx="1" cy="4" r="0.5"/>
<circle cx="2.34568" cy="1" r="0.5"/>
<circle cx="9" cy="4" r="0.5"/>
</g>
</svg>
)");
}

TEST(Svg, IsInMillimetresIfWidthIs) {
    const Palette palette{{{"", {1, 2, 3}}}, {.transparent = true}, Mixing::Cover};
    const std::string svg = svg_of(kPoints, page(100), 0.5, DotStyle::Fill, palette);
    EXPECT_NE(svg.find(R"(width="100mm" height="50mm" viewBox="0 0 100 50")"), std::string::npos);
    EXPECT_NE(svg.find(" mm;"), std::string::npos);
    EXPECT_NE(svg.find(R"(<g fill="#010203">)"), std::string::npos);
    EXPECT_NE(svg.find(R"(<circle cx="23.4568" cy="10" r="5"/>)"), std::string::npos);
    EXPECT_EQ(svg.find("<rect"), std::string::npos);
}

TEST(Svg, DrawsStrokesWithoutBackgroundForPens) {
    const std::string svg = svg_of(kPoints, page(100), 0.5, DotStyle::Stroke);
    EXPECT_NE(svg.find(R"(stroke-width="10" stroke-linecap="round">)"), std::string::npos);
    EXPECT_NE(svg.find("<path d=\"M10 40h0.1\nM23.4568 10h0.1\nM90 40h0.1\n\"/>"), std::string::npos);
    EXPECT_EQ(svg.find("<rect"), std::string::npos);
}

TEST(Svg, HasLayerForEachInk) {
    Palette palette{{{"cyan", {0, 255, 255}}, {"black", kBlack}}, kWhite, Mixing::Multiply};
    const Distribution all = dots_at(kPoints);
    const Distribution one = dots_at({{10, 20}});
    const std::vector<InkDots> inks = {{palette.inks[0], all, 0.5}, {palette.inks[1], one, 0.25}};
    EXPECT_EQ(
        test::whole_body([&](Body& body) { write_svg({inks}, palette, page(), {}, body); }),
        R"(<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" style="isolation:isolate" width="40" height="20" viewBox="0 0 10 5">
<rect width="10" height="5" fill="#ffffff"/>
<g id="layer1" inkscape:groupmode="layer" inkscape:label="cyan" style="mix-blend-mode:multiply">
<desc>3 dots along a path of 10.5873; in their original order it is 15.29931; their radius is 0.5</desc>
<g fill="#00ffff">
<circle cx="1" cy="4" r="0.5"/>
<circle cx="2.34568" cy="1" r="0.5"/>
<circle cx="9" cy="4" r="0.5"/>
</g>
</g>
<g id="layer2" inkscape:groupmode="layer" inkscape:label="black" style="mix-blend-mode:multiply">
<desc>1 dots along a path of 0; in their original order it is 0; their radius is 0.25</desc>
<g fill="#000000">
<circle cx="0" cy="5" r="0.25"/>
</g>
</g>
</svg>
)");
    palette.mixing = Mixing::Add;
    const std::string lights =
        test::whole_body([&](Body& body) { write_svg({inks}, palette, page(100), {.style = DotStyle::Stroke}, body); });
    EXPECT_NE(lights.find(R"(inkscape:label="cyan" style="mix-blend-mode:screen")"), std::string::npos);
    EXPECT_NE(lights.find(R"(stroke="#00ffff" stroke-width="10")"), std::string::npos);
    EXPECT_NE(lights.find(R"(stroke="#000000" stroke-width="5")"), std::string::npos);
    EXPECT_EQ(lights.find("<rect"), std::string::npos);
}

TEST(Svg, FillsDotsWithFinePens) {
    for (const DotStyle style : {DotStyle::Circles, DotStyle::Spiral}) {
        const std::string svg = svg_of(kPoints, page(100), 0.5, style);
        EXPECT_NE(svg.find(R"(stroke-width="0.3" stroke-linecap="round" stroke-linejoin="round">)"), std::string::npos);
        EXPECT_EQ(std::count(svg.begin(), svg.end(), 'M'), 3);
        EXPECT_GT(std::count(svg.begin(), svg.end(), 'L'), 3 * 100);
    }
}

TEST(Svg, JoinsDotsByOneLine) {
    const std::string svg = svg_of(kPoints, page(100), 0.5, DotStyle::Path);
    EXPECT_NE(svg.find("<path d=\"M10 40L23.4568 10L90 40\n\"/>"), std::string::npos);
    EXPECT_NE(svg_of({{15, 22}}, page(100), 0.5, DotStyle::Path).find("<path d=\"M50 30h0.1\n\"/>"), std::string::npos);
}

TEST(Svg, SplitsLongPaths) {
    std::vector<Point> points;
    for (int i = 0; i < 20'001; ++i) points.push_back({10 + i * 4e-4, 22});
    const std::string svg = svg_of(points, page(), 1e-4, DotStyle::Stroke);
    EXPECT_EQ(std::count(svg.begin(), svg.end(), 'M'), 20'001);
    std::size_t paths = 0;
    for (auto at = svg.find("<path"); at != std::string::npos; at = svg.find("<path", at + 1)) ++paths;
    EXPECT_EQ(paths, 3U);
    EXPECT_EQ(svg.find("h0\n"), std::string::npos);
}

TEST(Svg, KeepsPrecisionAtAnySize) {
    for (const double size : {1e-9, 1.0, 1e12}) {
        const Box box{{0, 0}, {size, size}};
        const std::vector<Point> points = {{size / 3, size / 3}};
        const std::string svg = svg_of(points, {box, false, false, canvas_of(box, 1), {}}, size, DotStyle::Fill);
        const auto at = svg.find("cx=\"") + 4;
        EXPECT_NEAR(std::stod(svg.substr(at)) / size, 1.0 / 3, 1e-6) << size;
    }
}

TEST(Svg, StopsOnRequest) {
    EXPECT_EQ(svg_of(kPoints, page(), 0.5, DotStyle::Fill, {}, {}, stopped_token()).find("<circle"), std::string::npos);
    const std::string hurried = svg_of(kPoints, page(), 0.5, DotStyle::Fill, {}, stopped_token());
    EXPECT_NE(hurried.find("<circle"), std::string::npos);
}

TEST(Points, AreFlippedIfYPointsUp) {
    const Raster raster = draw_points(std::vector<Point>{{11, 21}}, page(), 0.5);
    ASSERT_EQ(raster.width, 40);
    ASSERT_EQ(raster.height, 20);
    EXPECT_EQ(raster.coverage[16 * 40 + 4], 255);
    // The antialiased edge adds a twelfth to the squared radius.
    EXPECT_NEAR(mean(raster), 3.14159 * (4 + 1.0 / 12) / 800, 1e-4);
}

TEST(Points, KeepTheirInkOnTorus) {
    Page torus{{{0, 0}, {10, 5}}, true, true, canvas_of({{0, 0}, {10, 5}}, 16), {}};
    const double share = 3.14159265 * 0.25 / 50;
    for (const Point p : {Point{5, 2.5}, Point{0.1, 2.5}, Point{9.95, 2.5}, Point{5, 0.2}, Point{0.1, 4.9}}) {
        EXPECT_NEAR(mean(draw_points(std::vector<Point>{p}, torus, 0.5)), share, 0.02 * share) << p.x << ' ' << p.y;
    }
    torus.periodic = false;
    EXPECT_LT(mean(draw_points(std::vector<Point>{{0.1, 4.9}}, torus, 0.5)), 0.5 * share);
}

TEST(Canvas, ReducesScaleToPixelLimit) {
    const Box box{{0, 0}, {3, 1}};
    EXPECT_EQ(fitting_scale(box, 10, 300), 10);
    const double scale = fitting_scale(box, 1000, 300);
    EXPECT_TRUE(fits(canvas_of(box, scale), 300));
    EXPECT_GT(scale, 9.5);
    EXPECT_FALSE(fits(canvas_of(box, 11), 300));
    const Canvas thin = canvas_of({{0, 0}, {1, 1e-9}}, 10);
    EXPECT_EQ(thin.width, 10);
    EXPECT_EQ(thin.height, 1);
}

}  // namespace
}  // namespace ccdt::api

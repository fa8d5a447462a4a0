// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/points/tour/short_path.h"

namespace ccdt::api {
namespace {

double distance_to_segment(Point p, Point a, Point b) {
    const Point along = b - a;
    const double length = dot(along, along);
    const double share = length > 0 ? std::clamp(dot(p - a, along) / length, 0.0, 1.0) : 0;
    const Point off = p - (a + share * along);
    return std::sqrt(dot(off, off));
}

double distance_to_stroke(Point p, const std::vector<Point>& stroke) {
    double least = std::sqrt(dot(p - stroke.front(), p - stroke.front()));
    for (std::size_t i = 1; i < stroke.size(); ++i)
        least = std::min(least, distance_to_segment(p, stroke[i - 1], stroke[i]));
    return least;
}

class Filling : public testing::TestWithParam<DotStyle> {};

TEST_P(Filling, CoversTheDotAndNothingElse) {
    for (const double radius : {0.2, 0.31, 0.5, 1.0, 2.45, 15.0}) {
        constexpr double kPen = 0.3;
        const auto stroke = dot_stroke(GetParam(), radius, kPen);
        for (const Point& p : stroke) EXPECT_LE(std::sqrt(dot(p, p)), radius - kPen / 2 + 1e-12) << radius;
        for (int i = 0; i < 2'000; ++i) {
            const double angle = 2.399963 * i, from_centre = radius * std::sqrt((i + 0.5) / 2'000);
            const Point p{from_centre * std::cos(angle), from_centre * std::sin(angle)};
            EXPECT_LE(distance_to_stroke(p, stroke), kPen / 2 * 1.11) << radius << ' ' << from_centre;
        }
    }
}

TEST_P(Filling, IsASinglePointForPensAsWideAsTheDot) {
    for (const double radius : {1e-308, 0.1, 0.15}) EXPECT_EQ(dot_stroke(GetParam(), radius, 0.3).size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Styles, Filling, testing::Values(DotStyle::Circles, DotStyle::Spiral),
                         [](const auto& each) { return std::string(name_of(each.param)); });

const Box kBox = {{0, 0}, {10, 5}};

Page page_of(double width_mm) {
    return {kBox, false, false, {10, 5, 1}, width_mm};
}

Distribution dots_at(std::vector<Point> points) {
    Distribution dots;
    dots.points = std::move(points);
    return dots;
}

double seconds_of(const std::vector<Point>& points, double radius, const DrawingOptions& drawing) {
    const Ink ink;
    const Distribution dots = dots_at(points);
    const InkDots inks{ink, dots, radius};
    const Page page = page_of(*drawing.width_mm);
    return plot_of({{&inks, 1}}, page, drawing, {}).size().seconds;
}

TEST(PlotTime, CountsPathsAndPenLifts) {
    // The drawing is ten times as large on paper, so dots are 30 mm apart.
    const std::vector<Point> row = {{1, 1}, {4, 1}, {7, 1}};
    DrawingOptions drawing{.width_mm = 100, .style = DotStyle::Stroke, .plotter = {.speed = 20, .dwell = 0.5}};
    EXPECT_DOUBLE_EQ(seconds_of(row, 0.1, drawing), 60 / 20.0 + 3 * 2 * 0.5);
    drawing.style = DotStyle::Path;
    EXPECT_DOUBLE_EQ(seconds_of(row, 0.1, drawing), 60 / 20.0 + 2 * 0.5);
    drawing.style = DotStyle::Circles;
    drawing.pen_mm = 1.5;  // of a dot of 1 mm: one circle with a radius of 0.25 mm
    EXPECT_NEAR(seconds_of(row, 0.1, drawing), 60 / 20.0 + 3 * 2 * 0.5 + 3 * 2 * std::numbers::pi * 0.25 / 20, 0.01);
}

TEST(Plot, KeepsAPathThatHasBeenSearched) {
    const Ink ink;
    const Distribution dots = dots_at({{1, 1}, {4, 1}, {7, 1}});
    const std::vector<std::uint32_t> path = {1, 0, 2};  // not the shortest one
    InkDots inks{ink, dots, 0.1};
    inks.path = path;
    const Page page = page_of(100);
    EXPECT_EQ(plot_of({{&inks, 1}}, page, {.width_mm = 100}, {}).pens.front().runs.front().path, path);
}

TEST(PlotTime, OfALaserPausesForDotsOnly) {
    const std::vector<Point> row = {{1, 1}, {4, 1}, {7, 1}};
    DrawingOptions drawing{.width_mm = 100, .style = DotStyle::Stroke, .plotter = {.speed = 20, .dwell = 0.5}};
    drawing.plotter.machine = Machine::Laser;
    EXPECT_DOUBLE_EQ(seconds_of(row, 0.1, drawing), 60 / 20.0 + 3 * 0.5);
    drawing.style = DotStyle::Path;
    EXPECT_DOUBLE_EQ(seconds_of(row, 0.1, drawing), 60 / 20.0);
}

TEST(PlotSize, IsDescribedWithTheTone) {
    const Ink ink;
    const Distribution dots = dots_at({{1, 1}, {4, 1}, {7, 1}});
    const InkDots inks{ink, dots, 0.1};
    const DrawingOptions drawing{.width_mm = 100, .style = DotStyle::Path, .pen_mm = 0.25, .plotter = {.speed = 0.5}};
    const Page page = page_of(100);
    Plot plot = plot_of({.layers = {&inks, 1}, .tone = 0.875}, page, drawing, {});
    EXPECT_EQ(plot.description(), "3 dots, pen 0.25 mm, path 0.06 m, 2 min, tone 0.88");
    EXPECT_DOUBLE_EQ(plot.size().path_mm, 60);
    plot.tone.reset();
    EXPECT_TRUE(plot.description().ends_with(" min"));
}

TEST(PlotTime, IsMetByTheEstimatedNumberOfDots) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const DotStyle style : {DotStyle::Stroke, DotStyle::Path, DotStyle::Circles, DotStyle::Spiral}) {
        const DrawingOptions drawing{.width_mm = 200, .style = style};
        // Dots cover a quarter of the page; they are twice as dense on one half. The path through a hexagonal grid
        // would be slightly shorter.
        const PlotInk ink{0.25 * 200 * 100, (std::sqrt(1 / 3.0) + std::sqrt(1 / 6.0)) / 2 * 200 * 100};
        const double dots = dots_in(300, ink, std::nullopt, drawing);
        ASSERT_GT(dots, 100) << name_of(style);
        const double radius = std::sqrt(1.2 * ink.area / dots / std::numbers::pi) / 20;
        std::vector<Point> points;
        while (points.size() < static_cast<std::size_t>(dots)) {
            // The path through a jittered grid is about as long as through blue noise.
            const auto rows = static_cast<std::size_t>(std::sqrt(dots / 2));
            const auto columns = static_cast<std::size_t>(dots) / rows + 1;
            const std::size_t i = points.size();
            const double u =
                (static_cast<double>(i % columns) + 0.3 + 0.4 * uniform(random)) / static_cast<double>(columns);
            const double x = u < 2 / 3.0 ? u * 7.5 : 5 + (u - 2 / 3.0) * 15;
            points.push_back({x, 5 * (static_cast<double>(i / columns) + 0.3 + 0.4 * uniform(random)) /
                                     static_cast<double>(rows + 1)});
        }
        EXPECT_NEAR(seconds_of(points, radius, drawing), 300, 45) << name_of(style);
    }
}

TEST(PlotTime, AllowsNoDotsIfTooShort) {
    const DrawingOptions drawing{.width_mm = 200, .style = DotStyle::Stroke};
    EXPECT_EQ(dots_in(0.1, {100, 100}, std::nullopt, drawing), 0);
    EXPECT_EQ(dots_in(60, {1e5, 1e5}, std::nullopt, {.width_mm = 200, .style = DotStyle::Spiral}), 0);
    EXPECT_TRUE(std::isfinite(dots_in(1e300, {1e-300, 1e-300}, std::nullopt, drawing)));
}

TEST(PenWidth, MustFillDotsInAFewTurns) {
    const DrawingOptions fine{.width_mm = 100, .style = DotStyle::Spiral, .pen_mm = 0.1};
    const Page page = page_of(100);
    EXPECT_TRUE(check_pen(fine, 0.5, page, "pen"));
    const auto checked = check_pen(fine, 0.51, page, "/pen");
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().field, "/pen");
    EXPECT_EQ(checked.error().code, ErrorCode::Unusable);
    EXPECT_TRUE(check_pen({.width_mm = 100, .style = DotStyle::Path, .pen_mm = 0.1}, 5, page, "pen"));
}

}  // namespace
}  // namespace ccdt::api

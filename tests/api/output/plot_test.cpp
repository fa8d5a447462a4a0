#include "api/output/plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

TEST_P(Filling, IsATouchForPensAsWideAsTheDot) {
    for (const double radius : {1e-308, 0.1, 0.15}) EXPECT_EQ(dot_stroke(GetParam(), radius, 0.3).size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Styles, Filling, testing::Values(DotStyle::Circles, DotStyle::Spiral),
                         [](const auto& each) { return std::string(name_of(each.param)); });

const Box kBox = {{0, 0}, {10, 5}};

Page page_of(double width_mm) {
    return {kBox, false, false, {10, 5, 1}, width_mm};
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

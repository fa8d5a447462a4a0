// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/colour_difference.h"

#include <cmath>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

void expect_near(const Lab& lab, const Lab& expected, double tolerance) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(lab[i], expected[i], tolerance) << "component " << i;
}

double squared(const Lab& difference) {
    return difference[0] * difference[0] + difference[1] * difference[1] + difference[2] * difference[2];
}

TEST(LabOf, MatchesPublishedValues) {
    expect_near(lab_of({1, 1, 1}), {100, 0, 0}, 0.01);
    expect_near(lab_of({0, 0, 0}), {0, 0, 0}, 1e-9);
    expect_near(lab_of({1, 0, 0}), {53.24, 80.09, 67.20}, 0.05);
    expect_near(lab_of({0, 1, 0}), {87.73, -86.18, 83.18}, 0.05);
    expect_near(lab_of({0, 0, 1}), {32.30, 79.19, -107.86}, 0.05);
}

TEST(ColourDifference, MatchesCie94ExceptForLightness) {
    const Lab wanted{50, 30, 40};
    const ColourDifference difference(wanted);
    expect_near(difference(wanted), {0, 0, 0}, 1e-12);
    expect_near(difference({53, 30, 40}), {3, 0, 0}, 1e-12);
    const double chroma = 5 / (1 + 0.045 * 50), hue = 5 / (1 + 0.015 * 50);
    EXPECT_NEAR(squared(difference({50, 33, 44})), chroma * chroma / 4, 1e-9);
    EXPECT_NEAR(squared(difference({50, 34, 37})), hue * hue / 4, 1e-9);
}

TEST(ColourDifference, IsIsotropicAroundGreys) {
    const ColourDifference difference({50, 0, 0});
    for (const double angle : {0.0, 0.7, 2.0, 4.0}) {
        EXPECT_NEAR(squared(difference({50, 6 * std::cos(angle), 6 * std::sin(angle)})), 9, 1e-9);
    }
}

}  // namespace
}  // namespace ccdt

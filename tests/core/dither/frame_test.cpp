// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace ccdt {
namespace {

/// Returns a picture of three columns and two rows.
ColourPicture small() {
    return {3, 2, {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}, {0, 0, 0, 1, 1, 1}, {1, 1, 1, 0, 0, 0}, {}};
}

TEST(Frame, TurnsClockwise) {
    const ColourPicture quarter = turned(small(), 1);
    EXPECT_EQ(quarter.width, 2);
    EXPECT_EQ(quarter.height, 3);
    EXPECT_EQ(quarter.red, (Plane{0.4f, 0.1f, 0.5f, 0.2f, 0.6f, 0.3f}));
    EXPECT_EQ(turned(small(), 2).red, (Plane{0.6f, 0.5f, 0.4f, 0.3f, 0.2f, 0.1f}));
    EXPECT_EQ(turned(quarter, 3).red, small().red);
    EXPECT_EQ(turned(small(), 0).red, small().red);
}

TEST(Frame, KeepsPixelsOfAPictureThatIsNotScaled) {
    const LightPlanes light = framed(small(), {3, 2}, {3, 2}, {0, 0, 0});
    EXPECT_TRUE(std::ranges::equal(light[0], small().red));
    EXPECT_TRUE(std::ranges::equal(light[2], small().blue));
}

TEST(Frame, ClampsValuesOutsideOfTheRange) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity(), kNaN = std::numeric_limits<float>::quiet_NaN();
    const Plane odd{-1, 2, kInfinity, kNaN};
    for (const FrameSize& size : {FrameSize{4, 1}, FrameSize{3, 1}, FrameSize{9, 2}}) {
        for (const LightPlanes& light : {framed({4, 1, odd, odd, odd, {}}, size, size, {0.5f, 0.5f, 0.5f}),
                                         framed({4, 1, odd, odd, odd, odd}, size, size, {0.5f, 0.5f, 0.5f})}) {
            for (const float value : light[0]) EXPECT_TRUE(value >= 0 && value <= 1) << value;
        }
    }
    EXPECT_EQ(framed({4, 1, odd, odd, odd, {}}, {4, 1}, {4, 1}, {0, 0, 0})[1], (std::vector<float>{0, 1, 1, 0}));
}

TEST(Frame, CentresThePictureOnTheBackground) {
    const LightPlanes light = framed(small(), {3, 2}, {6, 4}, {0.9f, 0.8f, 0.7f});
    EXPECT_EQ(light[0].size(), 24U);
    EXPECT_EQ(light[0][0], 0.9f);
    EXPECT_EQ(light[0][6 + 1], 0.1f);
    EXPECT_EQ(light[1][6], 0.8f);
    EXPECT_EQ(light[2][6 + 4], 0.7f);
    EXPECT_EQ(light[0][12 + 3], 0.6f);
}

TEST(Frame, ShrinksToMeans) {
    const LightPlanes light = framed(small(), {1, 1}, {1, 1}, {0, 0, 0});
    EXPECT_NEAR(light[0][0], 0.35, 1e-6);
    EXPECT_NEAR(light[1][0], 0.5, 1e-6);
}

TEST(Frame, EnlargesWithinTheRangeOfThePicture) {
    const LightPlanes light = framed(small(), {30, 20}, {30, 20}, {0, 0, 0});
    EXPECT_EQ(light[0].size(), 600U);
    EXPECT_NEAR(light[0].front(), 0.1, 1e-6);
    EXPECT_NEAR(light[0].back(), 0.6, 1e-6);
    EXPECT_TRUE(std::ranges::all_of(light[0], [](float value) { return value >= 0.0999f && value <= 0.6001f; }));
}

TEST(Frame, ShowsTheBackgroundThroughTransparentPixels) {
    ColourPicture picture = small();
    picture.alpha = {0, 0.5f, 1, 1, 1, 1};
    const LightPlanes light = framed(picture, {3, 2}, {3, 2}, {1, 1, 1});
    EXPECT_EQ(light[0][0], 1.0f);
    EXPECT_NEAR(light[0][1], 0.6, 1e-6);
    EXPECT_EQ(light[0][2], 0.3f);
}

}  // namespace
}  // namespace ccdt

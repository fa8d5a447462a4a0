// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/levels.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

double decoded(double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

/// Returns a row of pixels with all 256 grey levels.
Picture greys() {
    const auto light = std::make_shared<float[]>(256);
    for (int level = 0; level < 256; ++level) light[level] = static_cast<float>(decoded(level / 255.0));
    return {256, 1, Plane(light, 256), {}};
}

TEST(Levels, StretchEncodedValues) {
    const Plane made = with_levels(greys(), {51 / 255.0, 204 / 255.0, 1}).luminance;
    for (const int level : {0, 30, 51}) EXPECT_EQ(made[static_cast<std::size_t>(level)], 0) << level;
    for (const int level : {204, 230, 255}) EXPECT_EQ(made[static_cast<std::size_t>(level)], 1) << level;
    for (int level = 52; level < 204; ++level) {
        EXPECT_NEAR(made[static_cast<std::size_t>(level)], decoded((level - 51) / 153.0), 1e-6) << level;
    }
}

TEST(Levels, ApplyGammaBetweenBlackAndWhite) {
    for (const double gamma : {0.1, 0.5, 2.0, 10.0}) {
        const Plane made = with_levels(greys(), {.gamma = gamma}).luminance;
        EXPECT_EQ(made[0], 0) << gamma;
        EXPECT_EQ(made[255], 1) << gamma;
        for (int level = 1; level < 255; ++level) {
            const double wanted = decoded(std::pow(level / 255.0, 1 / gamma));
            EXPECT_NEAR(made[static_cast<std::size_t>(level)], wanted, 0.002) << gamma << ' ' << level;
        }
    }
}

TEST(Levels, KeepPictureByDefault) {
    const Picture picture{2, 1, {0.3F, 0.7F}, {0.5F, 1.0F}};
    const Picture same = with_levels(picture, {});
    EXPECT_EQ(same.luminance.begin(), picture.luminance.begin());
    EXPECT_EQ(same.alpha.begin(), picture.alpha.begin());
}

TEST(Levels, ApplyToEachChannel) {
    const Levels levels{0.2, 0.9, 1.5};
    const ColourPicture made = with_levels(ColourPicture{2, 1, {0.1F, 0.2F}, {0.3F, 0.4F}, {0.5F, 0.6F}, {}}, levels);
    const Picture red{2, 1, {0.1F, 0.2F}, {}}, green{2, 1, {0.3F, 0.4F}, {}}, blue{2, 1, {0.5F, 0.6F}, {}};
    EXPECT_EQ(made.red, with_levels(red, levels).luminance);
    EXPECT_EQ(made.green, with_levels(green, levels).luminance);
    EXPECT_EQ(made.blue, with_levels(blue, levels).luminance);
    EXPECT_TRUE(made.alpha.empty());
}

TEST(Levels, AcceptNonFiniteNumbers) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Picture odd{4, 1, {-1, 2, kInfinity, std::numeric_limits<float>::quiet_NaN()}, {}};
    EXPECT_EQ(with_levels(odd, {.gamma = 2}).luminance, Plane({0, 1, 1, 0}));
    const Picture grey{1, 1, {0.25F}, {}};
    for (const double black : {0.0, 1 - 1e-16}) {
        const float made =
            with_levels(grey, {.black = black, .white = black + 1e-16 + (1 - black), .gamma = 1}).luminance[0];
        EXPECT_GE(made, 0);
        EXPECT_LE(made, 1);
    }
}

}  // namespace
}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/crop.h"

#include <gtest/gtest.h>

namespace ccdt {
namespace {

const Picture kPicture{4, 3, {0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23}, {}};

TEST(Crop, ReturnsMiddle) {
    const Picture part = part_around(kPicture, 2, 1, {});
    EXPECT_EQ(part.width, 2);
    EXPECT_EQ(part.height, 1);
    EXPECT_EQ(part.luminance, (Plane{11, 12}));
    EXPECT_TRUE(part.alpha.empty());
}

TEST(Crop, RoundsTowardsUpperLeft) {
    EXPECT_EQ(part_around(kPicture, 3, 2, {}).luminance, (Plane{0, 1, 2, 10, 11, 12}));
}

TEST(Crop, IsAsNearToThePointAsTheBordersPermit) {
    EXPECT_EQ(part_around(kPicture, 2, 1, {0, 0}).luminance, (Plane{0, 1}));
    EXPECT_EQ(part_around(kPicture, 2, 1, {1, 1}).luminance, (Plane{22, 23}));
    EXPECT_EQ(part_around(kPicture, 1, 1, {0.6, 0.3}).luminance, (Plane{1}));
    EXPECT_EQ(part_around(kPicture, 1, 1, {0.65, 0.5}).luminance, (Plane{12}));
    EXPECT_EQ(part_around(kPicture, 2, 3, {0.7, 0.9}).luminance, (Plane{1, 2, 11, 12, 21, 22}));
}

TEST(Crop, KeepsWholePicture) {
    EXPECT_EQ(part_around(kPicture, 4, 3, {0, 1}).luminance, kPicture.luminance);
}

TEST(Crop, CropsEachPlaneOfColour) {
    const ColourPicture picture{3, 1, {0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}};
    const ColourPicture part = part_around(picture, 1, 1, {});
    EXPECT_EQ(part.red, (Plane{1}));
    EXPECT_EQ(part.green, (Plane{4}));
    EXPECT_EQ(part.blue, (Plane{7}));
    EXPECT_EQ(part.alpha, (Plane{10}));
}

}  // namespace
}  // namespace ccdt

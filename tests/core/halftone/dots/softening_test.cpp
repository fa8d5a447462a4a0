// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/softening.h"

#include <gtest/gtest.h>

namespace ccdt {
namespace {

TEST(Softening, SpreadsPixelByWeights) {
    Raster raster{4, 3, 1, {0, 0, 0, 0, 0, 160, 0, 0, 0, 0, 0, 0}};
    Raster sharper = raster;
    soften(raster, 2);
    EXPECT_EQ(raster.coverage, (std::vector<std::uint8_t>{10, 20, 10, 0, 20, 40, 20, 0, 10, 20, 10, 0}));
    soften(sharper, 6);
    EXPECT_EQ(sharper.coverage, (std::vector<std::uint8_t>{3, 15, 3, 0, 15, 90, 15, 0, 3, 15, 3, 0}));
}

TEST(Softening, LeavesUniformAreasUnchangedUpToBorder) {
    for (const auto& [width, height] : {std::pair(1, 1), {5, 1}, {1, 5}, {7, 6}}) {
        const std::vector<std::uint8_t> even(static_cast<std::size_t>(width * height), 201);
        Raster raster{width, height, 1, even};
        soften(raster, 2);
        EXPECT_EQ(raster.coverage, even);
    }
}

}  // namespace
}  // namespace ccdt

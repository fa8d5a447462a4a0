// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numeric>
#include <vector>

#include "api/image/overlay.h"
#include "core/halftone/dots/dots.h"

namespace ccdt::api {

/// Returns a bilevel raster with dots where x + y is a multiple of 3. It is 19 pixels wide, so that the last byte of
/// each row is partly used.
inline Raster binary_raster() {
    Raster raster{19, 5, 1, {}};
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x) raster.coverage.push_back((x + y) % 3 == 0 ? 255 : 0);
    }
    return raster;
}

/// Returns a raster with every coverage once in each row.
inline Raster grey_raster(int height) {
    Raster raster{256, height, 1, std::vector<std::uint8_t>(256 * static_cast<std::size_t>(height))};
    for (auto row = raster.coverage.begin(); row != raster.coverage.end(); row += 256)
        std::iota(row, row + 256, std::uint8_t{0});
    return raster;
}

/// Draws a raster in one ink on paper.
inline DotImage image_of(const Raster& raster, bool antialias, const Colour& ink = kBlack,
                         const Colour& paper = kWhite) {
    return overlay({raster}, {{{"", ink}}, paper, Mixing::Cover}, antialias);
}

}  // namespace ccdt::api

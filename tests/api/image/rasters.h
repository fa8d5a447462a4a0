#pragma once

#include "core/halftone/dots.h"

namespace ccdt::api {

/// 19 wide, so that the last byte of a row is not full; dots where x + y is a multiple of 3.
inline Raster binary_raster() {
    Raster raster{19, 5, 1, {}};
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x) raster.coverage.push_back((x + y) % 3 == 0 ? 255 : 0);
    }
    return raster;
}

}  // namespace ccdt::api

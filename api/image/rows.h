#pragma once

#include <cstddef>
#include <cstdint>

#include "api/image/overlay.h"
#include "core/halftone/dots.h"

namespace ccdt::api {

/// The values that writers turn into a file's pixels, row by row; where they came from must outlive it.
struct Rows {
    explicit Rows(const Raster& raster) : width(raster.width), height(raster.height), values(raster.coverage.data()) {}
    explicit Rows(const ColourRaster& raster)
        : width(raster.width), height(raster.height), channels(raster.channels()), values(raster.pixels.data()) {}

    /// Values of a row.
    std::size_t size() const { return static_cast<std::size_t>(width) * channels; }
    const std::uint8_t* row(int y) const { return values + static_cast<std::size_t>(y) * size(); }

    int width;
    int height;
    std::size_t channels = 1;
    const std::uint8_t* values;  ///< [width * height * channels]
};

}  // namespace ccdt::api

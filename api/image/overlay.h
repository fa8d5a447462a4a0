#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "api/image/shades.h"
#include "api/input/print.h"
#include "core/halftone/dots.h"

namespace ccdt::api {

/// A picture in colour, as files of pictures hold it.
struct ColourRaster {
    int width = 0;
    int height = 0;
    bool transparent = false;          ///< pixels have an alpha
    std::size_t colours = 0;           ///< of the palette; 0: pixels are red, green, blue and, if transparent, alpha
    Shades palette{};                  ///< by the value of a pixel
    std::vector<std::uint8_t> pixels;  ///< [width * height * channels()], row by row

    std::size_t channels() const { return colours > 0 ? 1 : transparent ? 4 : 3; }
};

/// Lays the dots of several inks over each other, in linear light, as `printed` in core/halftone/separation.h does.
/// Where nothing is below them, print is seen on white, and pixels are as opaque as dots cover them.
///
/// @param rasters    [inks], all of one size
/// @param antialias  false: they hold 0 and 255 only, and the picture has a palette of all mixtures
/// @param stop       asked at each row; a stop ends it early, with nothing of use
ColourRaster overlay(std::span<const Raster> rasters, const Print& print, bool antialias,
                     const std::stop_token& stop = {});

}  // namespace ccdt::api

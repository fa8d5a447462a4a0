#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "api/image/shades.h"
#include "api/input/palette.h"
#include "core/halftone/dots.h"
#include "core/parallel/executor.h"

namespace ccdt::api {

/// Picture of dots, as files of pictures hold it.
struct DotImage {
    int width = 0;
    int height = 0;
    bool transparent = false;          ///< pixels have an alpha
    bool grey = false;                 ///< all its colours are greys, and files may store it as grey
    std::size_t colours = 0;           ///< of the palette; 0: pixels are red, green, blue and, if transparent, alpha
    Shades palette{};                  ///< by the value of a pixel
    std::vector<std::uint8_t> pixels;  ///< [width * height * channels()], row by row

    std::size_t channels() const { return colours > 0 ? 1 : transparent ? 4 : 3; }

    /// Values of a row.
    std::size_t row_size() const { return static_cast<std::size_t>(width) * channels(); }
    const std::uint8_t* row(int y) const { return pixels.data() + static_cast<std::size_t>(y) * row_size(); }

    /// Tells whether there is nothing but black and white.
    bool is_bilevel() const;
};

/// Lays the dots of inks over each other and their paper, in linear light: an ink that covers as shades_of() does,
/// others as `printed` in core/halftone/separation.h. Where the paper is transparent, inks are seen on white, and
/// pixels are as opaque as dots cover them.
///
/// @param rasters    [inks], all of one size
/// @param antialias  false: they hold 0 and 255 only, and the picture has a palette of all mixtures
/// @param stop       asked now and then where inks mix; a stop ends it early, with nothing of use
/// Same input, same bytes, whatever the executor.
DotImage overlay(std::vector<Raster> rasters, const Palette& palette, bool antialias, const std::stop_token& stop = {},
                 Executor& executor = inline_executor());

/// Lays antialiased dots of inks that multiply, each of which flips some inks of its ground, over each other. Where
/// dots flip several inks, these have their rims in common: the parts of a pixel that inks have flipped are nested.
///
/// @param flipped  [inks] share of each pixel in which the ink is flipped
/// @param grounds  [inks] share of each pixel that is ground of the ink
DotImage overlay_flipped(std::span<const Raster> flipped, std::span<const Raster> grounds, const Palette& palette,
                         const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt::api

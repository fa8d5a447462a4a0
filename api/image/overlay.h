// SPDX-License-Identifier: GPL-3.0-or-later
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

/// Picture of dots, as it is stored in image files.
struct DotImage {
    int width = 0;
    int height = 0;
    bool transparent = false;          ///< pixels have alpha
    bool grey = false;                 ///< all colours are grey, and files may store them as such
    std::size_t colours = 0;           ///< of the palette; 0: pixels are red, green, blue and, if transparent, alpha
    Shades palette{};                  ///< by pixel value
    std::vector<std::uint8_t> pixels;  ///< [width * height * channels()], row by row

    std::size_t channels() const { return colours > 0 ? 1 : transparent ? 4 : 3; }

    /// Returns the number of values in a row.
    std::size_t row_size() const { return static_cast<std::size_t>(width) * channels(); }
    const std::uint8_t* row(int y) const { return pixels.data() + static_cast<std::size_t>(y) * row_size(); }

    /// Returns whether the picture is only black and white.
    bool is_bilevel() const;
};

/// Lays the dots of inks over each other and their paper, in linear light: an ink that covers the paper by shades_of(),
/// others by printed() in core/halftone/separation.h. On transparent paper, inks look as on white, and pixels are as
/// opaque as dots cover them.
///
/// @param rasters    [inks], all of one size
/// @param antialias  if false, they contain only 0 and 255, and the picture has a palette of all mixtures
/// @param stop       polled now and then if inks mix; a stop ends early with a useless result
/// Same input, same bytes, on any executor.
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

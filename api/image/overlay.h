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

/// Picture of dots, as image files store it.
struct DotImage {
    int width = 0;
    int height = 0;
    bool transparent = false;  ///< whether pixels have alpha
    bool grey = false;         ///< whether all colours are grey, so that files can store grey values
    /// Number of colours in the palette. 0: pixels are red, green, blue and, if transparent, alpha.
    std::size_t colours = 0;
    Shades palette{};                  ///< colour of each pixel value
    std::vector<std::uint8_t> pixels;  ///< [width * height * channels()], row by row

    std::size_t channels() const { return colours > 0 ? 1 : transparent ? 4 : 3; }

    /// Returns the number of values in a row.
    std::size_t row_size() const { return static_cast<std::size_t>(width) * channels(); }
    const std::uint8_t* row(int y) const { return pixels.data() + static_cast<std::size_t>(y) * row_size(); }

    /// Returns whether the picture is only black and white.
    bool is_bilevel() const;
};

/// Combines the dots of all inks with each other and the paper, in linear light. An ink with the mixing Cover uses
/// shades_of(); inks with other mixings use printed() in core/halftone/overprint.h. On transparent paper, inks have the
/// colours that they have on white paper, and the opacity of a pixel is the share that dots cover.
///
/// @param rasters    [inks], all of one size
/// @param antialias  if false, the rasters contain only 0 and 255, and the picture has a palette of all mixtures of
///                   inks
/// @param stop       not polled for Cover; after a stop, the result is incomplete
/// The same input gives the same bytes on any executor.
DotImage overlay(std::vector<Raster> rasters, const Palette& palette, bool antialias, const std::stop_token& stop = {},
                 Executor& executor = inline_executor());

/// Combines antialiased dots of inks that multiply. Each dot flips some inks: it removes such an ink where the ground
/// has the ink, and adds the ink elsewhere. All inks that a dot flips share the rim of the dot. So the areas of a pixel
/// in which different inks are flipped are assumed to be nested.
///
/// @param flipped  [inks] share of each pixel in which dots flip the ink
/// @param grounds  [inks] share of each pixel in which the ground has the ink
DotImage overlay_flipped(std::span<const Raster> flipped, std::span<const Raster> grounds, const Palette& palette,
                         const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt::api

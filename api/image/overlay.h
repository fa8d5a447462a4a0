// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "api/image/shades.h"
#include "api/input/palette.h"
#include "core/base/executor.h"
#include "core/halftone/dots/dots.h"

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
/// shades_of(); inks with other mixings use printed() in core/halftone/inks/overprint.h. On transparent paper, inks
/// have the colours that they have on white paper, and the opacity of a pixel is the share that dots cover.
///
/// @param rasters    [inks], all of one size
/// @param antialias  if false, the rasters contain only 0 and 255, and the picture has a palette of all mixtures of
///                   inks
/// @param stop       not polled for Cover; after a stop, the result is incomplete
/// The same input gives the same bytes on any executor.
DotImage overlay(std::vector<Raster> rasters, const Palette& palette, bool antialias, const std::stop_token& stop = {},
                 Executor& executor = inline_executor());

/// Calls function(set, share) for each set of inks that covers a part of a pixel. The share is at most 255.
/// @param boundaries  [sets - 1] share of each pixel that the sets up to this one cover together; ascending
template <class Function>
void for_sets(std::span<const Raster> boundaries, std::size_t pixel, const Function& function) {
    unsigned covered = 0;
    for (std::size_t set = 0; set <= boundaries.size() && covered < 255; ++set) {
        const unsigned next = set < boundaries.size() ? boundaries[set].coverage[pixel] : 255;
        if (next > covered) function(set, next - covered);
        covered = next;
    }
}

/// Combines areas that sets of inks cover, side by side. Inks have the mixing Multiply.
/// @param sets        inks of each set, as bits
/// @param boundaries  as for for_sets()
DotImage overlay_sets(std::span<const Raster> boundaries, std::span<const unsigned> sets, const Palette& palette,
                      bool antialias, const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt::api

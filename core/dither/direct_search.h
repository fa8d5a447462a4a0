// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/dither/device_colours.h"
#include "core/dither/visual_error.h"

namespace ccdt {

/// Settings of a search.
struct SearchOptions {
    /// Whether pixels only exchange their colours with neighbouring pixels, so that the number of pixels of each colour
    /// is kept. Otherwise, pixels may also take other colours.
    bool keeps_counts = false;

    double blur = kEyeBlur;  ///< of the error, see VisualError
};

/// Reduces the visible error (VisualError) of a picture in the colours of a device. Changes single pixels and exchanges
/// neighbouring pixels, until hardly any such step reduces the error.
///
/// @param wanted  [width * height] wanted colours in the opponent space
/// @param given   [width * height] number of a colour that the pixel keeps, or kAnyColour
/// @param chosen  [width * height] initial numbers of colours; equal to `given` where a colour is given
/// @param stop    polled many times in each sweep; a stop returns the improved picture so far
/// @returns       [width * height] numbers of colours
///
/// Deterministic for any number of threads. O(pixels * colours) per sweep; there are about ten sweeps, and later sweeps
/// visit few pixels. Source: Analoui, Allebach 1992, Model-based halftoning using direct binary search. Departures: any
/// number of colours; an error with several scales; sweeps over tiles in parallel.
std::vector<std::uint8_t> search_directly(std::span<const DeviceColours::Opponent> wanted,
                                          std::span<const std::uint8_t> given, std::vector<std::uint8_t> chosen,
                                          int width, int height, const DeviceColours& device,
                                          const SearchOptions& options = {}, const std::stop_token& stop = {},
                                          Executor& executor = inline_executor());

}  // namespace ccdt

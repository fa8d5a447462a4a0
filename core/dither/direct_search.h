// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/dither/device_colours.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Improves a picture in the colours of a device, until no change of a pixel and no exchange of two neighbouring pixels
/// makes the visible error (VisualError) smaller, or nearly none does.
///
/// @param blur    standard deviation of the blur of the eye, in pixels
/// @param wanted  [width * height] colours in the opponent space
/// @param given   [width * height] number of a colour that the pixel keeps, or kAnyColour
/// @param chosen  [width * height] numbers of colours to begin with; given pixels must have their colours
/// @param stop    polled many times in each sweep; a stop returns the picture as it is then
/// @returns       [width * height] numbers of colours
///
/// Deterministic for any number of threads. O(pixels * colours) per sweep; about ten sweeps, of which the later ones
/// visit few pixels. Source: Analoui, Allebach 1992, Model-based halftoning using direct binary search. Departures: any
/// number of colours; an error with several scales; sweeps over tiles in parallel.
std::vector<std::uint8_t> search_directly(double blur, std::span<const DeviceColours::Opponent> wanted,
                                          std::span<const std::uint8_t> given, std::vector<std::uint8_t> chosen,
                                          int width, int height, const DeviceColours& device,
                                          const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt

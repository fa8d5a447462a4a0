// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/dither/printed_spot.h"

namespace ccdt {

/// Chooses the dark pixels of a picture that is printed with round spots (PrintedSpot), so that the print looks like
/// the picture.
///
/// Error diffusion begins: a dark pixel counts as the area that its spot covers and that earlier spots do not. Then
/// changes of a pixel, and exchanges of two neighbouring pixels, reduce the visible error (VisualError) of the print,
/// as in search_directly(), for one eye after the other. A change of one pixel changes the print in the squares of up
/// to nine pixels.
///
/// @param wanted  [width * height] share of each square that ink should cover
/// @param given   [width * height] 0 (light), 1 (dark), or kAnyColour
/// @param stop    polled many times in each sweep; a stop returns the picture as it is then
/// @returns       [width * height] whether each pixel is dark
///
/// Deterministic for any number of threads. O(pixels) per sweep. Source: Pappas, Neuhoff 1999, Least-squares
/// model-based halftoning.
std::vector<std::uint8_t> search_spots(std::span<const float> wanted, std::span<const std::uint8_t> given, int width,
                                       int height, const PrintedSpot& spot, const std::stop_token& stop = {},
                                       Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/dither/error_diffusion.h"
#include "core/halftone/inks/overprint.h"

namespace ccdt {

/// Shows a picture on a device whose pixels each show one of a few colours, such as electronic paper.
///
/// Maps black to the device's darkest colour and white to its lightest colour, linearly in light. Maps colours that no
/// mixture of the device's colours can make to the most similar colours (DeviceGamut). Then error diffusion chooses the
/// colours of the pixels, and searches with different blurs reduce the visible error (diffuse_error(),
/// search_directly()).
///
/// If the darker one of two colours is printed as round spots, the search compares the picture with the print
/// (search_spots()). Black becomes the darkest print, which has gaps between spots if their diameter is less than
/// sqrt(2).
///
/// @param light     red, green and blue [width * height] in linear light; values outside [0, 1] are clamped
/// @param given     [width * height] number of a colour that the pixel must have, or kAnyColour
/// @param colours   2 to kMaxDeviceColours different colours, as they look on the device, in linear light
/// @param diameter  diameter of printed spots in pixels, kMinSpot to kMaxSpot; 0: pixels are squares
/// @param stop      after a stop, the result is less similar to the picture
/// @returns         [width * height] numbers of colours
///
/// Deterministic for any number of threads. O(pixels * colours).
std::vector<std::uint8_t> dither(const LightPlanes& light, std::span<const std::uint8_t> given, int width, int height,
                                 std::span<const Light> colours, double diameter = 0, const std::stop_token& stop = {},
                                 Executor& executor = inline_executor());

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/dither/device_colours.h"

namespace ccdt {

/// Marks a pixel whose colour is not given.
inline constexpr std::uint8_t kAnyColour = 255;

/// Chooses a colour of the device for each pixel. The difference from the wanted colour is passed on to neighbouring
/// pixels that are chosen later, so that local means stay nearly the same.
///
/// @param wanted  [width * height] wanted colours in the opponent space, within the device's gamut
/// @param given   [width * height] number of a colour that the pixel must have, or kAnyColour
/// @returns       [width * height] numbers of colours
///
/// Deterministic. O(pixels * colours).
/// Source: Floyd, Steinberg 1976, An adaptive algorithm for spatial greyscale. The direction alternates between rows.
/// Departure: given pixels neither receive an error nor pass one on.
std::vector<std::uint8_t> diffuse_error(std::span<const DeviceColours::Opponent> wanted,
                                        std::span<const std::uint8_t> given, int width, int height,
                                        const DeviceColours& device);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Encodes a picture as a PNG file. Pictures in black and white have 1 bit per pixel; antialiased grey pictures have 8
/// bits per pixel. Other pictures with a palette, such as pictures in two greys, have a palette in the file and 1 to 8
/// bits per pixel. All other pictures have 8 bits per channel. Values are sRGB, as the chunks sRGB, gAMA and cHRM
/// state.
///
/// @param width_mm  width of the picture; none: the file has no physical size
/// @param stop      polled once per row
/// The same input gives the same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_png(const DotImage& image, std::optional<double> width_mm = {},
                              const std::stop_token& stop = {});

/// Encodes grey values as a PNG file without a colour space.
/// @param greys  [width * height] row by row
/// @param bits   bits of each value, 8 or 16
/// `stop` and the errors are as for write_png().
Result<std::string> write_greys(std::span<const std::uint16_t> greys, int width, int height, int bits,
                                const std::stop_token& stop = {});

}  // namespace ccdt::api

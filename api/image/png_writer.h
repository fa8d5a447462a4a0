// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/result.h"

namespace ccdt::api {

/// Encodes a picture as a PNG file: black and white with 1 bit per pixel, other greys with 8 bits, few colours as a
/// palette with 1 to 8 bits, others with 8 bits per channel. Bilevel pictures in two other greys have a palette, too.
/// Values are sRGB, as the chunks sRGB, gAMA and cHRM state.
///
/// @param width_mm  of the picture; none: the file has no physical size
/// @param stop      polled at each row
/// Same input, same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_png(const DotImage& image, std::optional<double> width_mm = {},
                              const std::stop_token& stop = {});

/// Encodes grey values as a PNG file that does not define their meaning.
/// @param greys  [width * height] row by row
/// @param bits   of each, 8 or 16
/// Otherwise as write_png().
Result<std::string> write_greys(std::span<const std::uint16_t> greys, int width, int height, int bits,
                                const std::stop_token& stop = {});

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/base/result.h"

namespace ccdt::api {

inline constexpr int kMaxJpegSide = 65'500;  ///< pixels; the limit of libjpeg

/// Encodes a picture as a baseline JPEG file with 8 bits per channel. Colours have the full resolution, because dots
/// of half the resolution would have coloured rims.
///
/// @param image     not transparent; each side at most kMaxJpegSide
/// @param quality   1 to 100, the scale of libjpeg
/// @param width_mm  width of the picture, which gives the resolution in dots per inch; none: the file has no physical
///                  size
/// @param stop      polled once per row
/// The same input gives the same bytes on any processor. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_jpeg(const DotImage& image, int quality, std::optional<double> width_mm = {},
                               const std::stop_token& stop = {});

}  // namespace ccdt::api

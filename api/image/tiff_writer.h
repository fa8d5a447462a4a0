// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Encodes a picture as a TIFF file. Black and white pictures have 1 bit per pixel, compressed by CCITT group 4, which
/// printers prefer. All other pictures have 8 bits per channel, compressed by Deflate.
///
/// @param width_mm  width of the picture, which gives the resolution in dots per inch; none: the file has no physical
///                  size
/// @param stop      polled once per row
/// The same input gives the same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_tiff(const DotImage& image, std::optional<double> width_mm = {},
                               const std::stop_token& stop = {});

/// Encodes the coverage of each ink as printing plates: a separated picture with a channel of 8 bits for each ink,
/// compressed by Deflate. The value 255 is solid ink. Tags name the inks. If the inks are cyan, magenta, yellow and
/// black, a tag says so, and any reader can show the picture. The colour of the paper is not stored. The other
/// parameters and the errors are those of write_tiff().
///
/// @param plates  [inks], all of one size
/// Source: TIFF 6.0, 16.
Result<std::string> write_tiff_plates(std::span<const Raster> plates, std::span<const Ink> inks,
                                      std::optional<double> width_mm = {}, const std::stop_token& stop = {});

}  // namespace ccdt::api

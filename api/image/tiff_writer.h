#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "api/input/colour.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

/// Encodes a raster as a TIFF file. What pixels look like: see Shades.
///
/// @param antialias  false: the raster holds 0 and 255 only. Black and white are then 1 bit a pixel, compressed by
///                   CCITT group 4, as printers like it; all else is 8 bits a channel, compressed by Deflate.
/// @param width_mm   of the picture, for its resolution in dots per inch; none: the file tells no physical size
/// @param stop       asked at each row
/// Same input, same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_tiff(const Raster& raster, bool antialias, const Inks& inks,
                               std::optional<double> width_mm = {}, const std::stop_token& stop = {});

/// The same of a picture in colour, 8 bits a channel.
Result<std::string> write_tiff(const ColourRaster& raster, std::optional<double> width_mm = {},
                               const std::stop_token& stop = {});

}  // namespace ccdt::api

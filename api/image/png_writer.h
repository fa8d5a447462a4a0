#pragma once

#include <optional>
#include <string>

#include "api/image/overlay.h"
#include "api/input/colour.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

/// Encodes a raster as a PNG file.
///
/// @param antialias  false: the raster holds 0 and 255 only and becomes 1 bit a pixel; true: 8 bits a pixel.
///                   Grey where both inks are (binary: black and white), otherwise a palette.
/// What pixels look like: see Shades.
/// @param width_mm   of the picture; none: the file tells no physical size
/// Same input, same bytes. Errors: Internal if memory runs out.
Result<std::string> write_png(const Raster& raster, bool antialias, const Inks& inks,
                              std::optional<double> width_mm = {});

/// The same of a picture in colour: 1 to 8 bits a pixel if it has a palette, else 8 bits a channel.
Result<std::string> write_png(const ColourRaster& raster, std::optional<double> width_mm = {});

}  // namespace ccdt::api

#pragma once

#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "api/input/colour.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

inline constexpr int kMaxWebPSide = 16'383;  ///< pixels

/// Encodes a raster as a WebP file without loss. What pixels look like: see Shades.
///
/// @param raster  at most kMaxWebPSide each way
/// @param stop    asked now and then
/// Same input, same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_webp(const Raster& raster, const Inks& inks, const std::stop_token& stop = {});
Result<std::string> write_webp(const ColourRaster& raster, const std::stop_token& stop = {});

}  // namespace ccdt::api

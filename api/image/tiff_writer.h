#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/result.h"

namespace ccdt::api {

/// Encodes a picture as a TIFF file. Black and white are 1 bit a pixel, compressed by CCITT group 4, as printers like
/// it; all else is 8 bits a channel, compressed by Deflate.
///
/// @param width_mm  of the picture, for its resolution in dots per inch; none: the file tells no physical size
/// @param stop      asked at each row
/// Same input, same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_tiff(const DotImage& image, std::optional<double> width_mm = {},
                               const std::stop_token& stop = {});

/// Encodes what each ink covers as the plates that print it: a separated picture, a channel of 8 bits for each ink, 255
/// where it is solid, compressed by Deflate. Its tags name the inks; those of `cmyk` are told to be these, so that any
/// reader shows them. The paper is not in it. The other parameters are those of write_tiff().
///
/// @param plates  [inks], all of one size
/// Source: TIFF 6.0, 16.
Result<std::string> write_tiff_plates(std::span<const Raster> plates, std::span<const Ink> inks,
                                      std::optional<double> width_mm = {}, const std::stop_token& stop = {});

}  // namespace ccdt::api

#pragma once

#include <optional>
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

}  // namespace ccdt::api

#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Decodes the first frame of a GIF file, which stands on a transparent ground where it does not cover the picture.
///
/// Needs a byte a pixel.
/// @param bytes  must outlive the rows' source
/// Errors: Unusable for a broken or shortened file, for one without a frame, and for a frame that stands over the
/// border of the picture.
/// Source: GIF89a (CompuServe, 1990).
Result<RowSource> open_gif(std::string_view bytes);

}  // namespace ccdt::api

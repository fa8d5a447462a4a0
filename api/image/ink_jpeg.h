#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a JPEG of cyan, magenta, yellow and black, be it YCCK, by libjpeg; all of them store how much paper is left,
/// as Adobe's do.
///
/// @param bytes  must outlive the rows' source
/// Errors: Unusable for a broken or shortened file, and for one of other colours.
Result<RowSource> open_ink_jpeg(std::string_view bytes);

}  // namespace ccdt::api

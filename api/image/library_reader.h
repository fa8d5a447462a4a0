#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a PNG, JPEG, WebP or TIFF file by OpenImageIO, which must not be shown colour profiles: it trusts them.
///
/// @param bytes      must outlive the rows' source
/// @param header     as read_image_header told it
/// @param keep_inks  of a TIFF of cyan, magenta, yellow and black; else they come as red, green and blue
/// Errors: Unusable for a broken or shortened file, and for kinds of TIFF that are not read. May throw, as may the
/// source.
Result<RowSource> open_by_library(std::string_view bytes, const ImageHeader& header, bool keep_inks);

}  // namespace ccdt::api

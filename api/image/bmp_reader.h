#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a BMP file: with a palette or without, packed by runs or not, with fields of any width for its colours. Alpha
/// counts only where the file says where it lies, and unless it is 0 all over.
///
/// Needs a byte a pixel if it is packed by runs.
/// @param bytes  must outlive the rows' source
/// Errors: Unusable for a broken or shortened file, and for one that holds a JPEG or PNG.
/// Source: Microsoft, Windows GDI, "Bitmap Storage" and BITMAPV5HEADER.
Result<RowSource> open_bmp(std::string_view bytes);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a BMP file: with or without a palette, run-length encoded or not, with colour fields of any width. Alpha
/// counts only if the file defines its field, and if it is not 0 everywhere.
///
/// Needs a byte per pixel if the file is run-length encoded.
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, and for one that contains a JPEG or PNG.
/// Source: Microsoft, Windows GDI, "Bitmap Storage" and BITMAPV5HEADER.
Result<RowSource> open_bmp(std::string_view bytes);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Opens a BMP file: with or without a palette, run-length encoded or not, with colour fields of any width. Alpha is
/// used only if the file defines a field for it and at least one pixel has an alpha other than 0.
///
/// A run-length encoded file needs one byte of memory per pixel.
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, and for a file that contains a JPEG or PNG.
/// Source: Microsoft, Windows GDI, "Bitmap Storage" and BITMAPV5HEADER.
///
/// Why not OpenImageIO: version 2.4 refuses 2 bits per pixel, RLE4, absolute runs, headers of 64 bytes, and palettes of
/// more than 256 colours. It ignores most bit fields, and treats the unused byte of 32-bit pixels as alpha.
Result<RowSource> open_bmp(std::string_view bytes);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "api/image/tiff_pixels.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Opens a page of a TIFF by libtiff, which only decompresses the pixels. Only kinds that the tests cover are read:
///
/// - grey (0 is black or white), RGB, palettes, CMYK, YCbCr, CIELAB and ICCLAB;
/// - integers of 1 to 32 bits; floats of 16, 24, 32 and 64 bits in grey, RGB and CMYK; 8 bits in YCbCr; 8 and 16 bits
///   in Lab; with TiffUse::Values, also integers with sign;
/// - strips and tiles, with interleaved samples or separate planes; alpha, and other channels, which are ignored;
/// - uncompressed; PackBits, LZW, Deflate, LZMA, Zstandard, WebP, JPEG, and CCITT groups 3 and 4.
///
/// @param bytes      must outlive the row source
/// @param header     result of read_image_header(); the page must have this size
/// @param directory  offset of the page's directory in the file
/// Errors: Unusable for other kinds, which the message names, and for a broken file. This function and the row source
/// may throw. One block of the file, and the rows that contain it, are in memory at a time.
/// Sources: TIFF 6.0; Adobe's TIFF technical notes of 2002.
Result<RowSource> open_tiff(std::string_view bytes, const ImageHeader& header, TiffUse use, std::size_t directory);

}  // namespace ccdt::api

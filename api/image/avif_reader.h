// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Decodes the primary item of an AVIF file, animated or not, by libavif and dav1d, in the calling thread. Samples of
/// more than 8 bits are converted to 16 bits.
///
/// @param bytes   must outlive the row source
/// @param header  result of read_image_header()
/// Errors: Unusable for a broken or truncated file, and for a file that crops its picture.
/// Source: AV1 Image File Format 1.1; HEIF (ISO/IEC 23008-12), 6.5.10 and 6.5.12.
Result<RowSource> open_avif(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api

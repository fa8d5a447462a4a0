// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Decodes the primary item of a HEIC file by libheif and libde265, in the calling thread. Applies the crop, the
/// rotation and the mirroring of the item. Samples of more than 8 bits are converted to 16 bits. Thumbnails, depth maps
/// and gain maps are ignored.
///
/// @param bytes   must outlive the row source
/// @param header  result of read_image_header()
/// Errors: Unusable for a broken or truncated file, and for features that libheif does not support.
/// Source: HEIF (ISO/IEC 23008-12).
Result<RowSource> open_heic(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a PNG, JPEG, WebP or TIFF file by OpenImageIO. The file must not have a colour profile, because OpenImageIO
/// does not check profiles.
///
/// @param bytes      must outlive the row source
/// @param header     result of read_image_header()
/// @param keep_inks  whether the rows of a TIFF in cyan, magenta, yellow and black keep these channels; if not, they
///                   are converted to red, green and blue
/// @param page       number of the page of a TIFF, from 0
/// Errors: Unusable for a broken or truncated file, for kinds of TIFF that are not supported, and for a page whose size
/// is not that of the first page. This function and the row source may throw.
Result<RowSource> open_by_library(std::string_view bytes, const ImageHeader& header, bool keep_inks, int page = 0);

}  // namespace ccdt::api

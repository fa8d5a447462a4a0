// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Opens a PNG, JPEG or WebP file by OpenImageIO. The file must not have a colour profile, because OpenImageIO does not
/// check profiles.
///
/// @param bytes      must outlive the row source
/// @param header     result of read_image_header()
/// Errors: Unusable for a broken or truncated file. This function and the row source may throw.
Result<RowSource> open_by_library(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api

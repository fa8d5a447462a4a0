// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Opens a JPEG in cyan, magenta, yellow and black, or in YCCK, by libjpeg. Files of both kinds store the share of bare
/// paper, as Adobe's do.
///
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, and for one in other colours.
Result<RowSource> open_ink_jpeg(std::string_view bytes);

}  // namespace ccdt::api

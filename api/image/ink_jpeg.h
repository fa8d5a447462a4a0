// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Opens a JPEG in cyan, magenta, yellow and black, or in YCCK, by libjpeg. Both kinds are assumed to store inverted
/// values, the share of bare paper, as Adobe's programs do.
///
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, and for a file without four channels.
Result<RowSource> open_ink_jpeg(std::string_view bytes);

}  // namespace ccdt::api

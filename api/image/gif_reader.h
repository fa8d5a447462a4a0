// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Decodes the first frame of a GIF file. The picture is transparent where the frame does not cover it.
///
/// Needs a byte per pixel.
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, for one without a frame, and for a frame that reaches beyond the
/// picture.
/// Source: GIF89a (CompuServe, 1990).
Result<RowSource> open_gif(std::string_view bytes);

}  // namespace ccdt::api

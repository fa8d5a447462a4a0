// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Decodes the first frame of a GIF file. Parts of the picture that the frame does not cover are transparent.
///
/// Needs a byte of memory per pixel.
/// @param bytes  must outlive the row source
/// Errors: Unusable for a broken or truncated file, for a file without a frame, and for a frame that extends beyond the
/// picture.
/// Source: GIF89a (CompuServe, 1990).
Result<RowSource> open_gif(std::string_view bytes);

}  // namespace ccdt::api

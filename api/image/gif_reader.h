// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Decodes the first frame of a GIF file by giflib. Parts of the picture that the frame does not cover are transparent.
///
/// Needs one byte of memory per pixel.
/// @param bytes   must outlive the row source
/// @param header  result of read_image_header()
/// If the frame ends beyond the screen, the picture is larger than the screen, as in Chromium and Pillow.
/// Errors: Unusable for a broken or truncated file, and for a file without a frame. The empty block after the frame and
/// all data after this block may be missing.
/// Source: GIF89a (CompuServe, 1990).
///
/// Why not OpenImageIO: version 2.4 needs four times the memory, reads wrong colours where the palette is too short,
/// and applies the transparent colour of an earlier control block.
Result<RowSource> open_gif(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api

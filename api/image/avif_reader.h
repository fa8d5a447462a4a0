#pragma once

#include <string_view>

#include "api/image/image_header.h"
#include "api/image/row_source.h"
#include "core/result.h"

namespace ccdt::api {

/// Decodes the picture that an AVIF file shows, of a film that which stands for it, by libavif and dav1d, in this
/// thread. More than 8 bits become 16.
///
/// @param bytes   must outlive the rows' source
/// @param header  as read_image_header told it
/// Errors: Unusable for a broken or shortened file, and for one that is to be cropped.
/// Source: AV1 Image File Format 1.1; HEIF (ISO/IEC 23008-12), 6.5.10 and 6.5.12.
Result<RowSource> open_avif(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api

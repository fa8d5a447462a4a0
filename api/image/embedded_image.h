// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "api/image/image_header.h"
#include "api/input/option_reader.h"
#include "api/run/options.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Decodes base64 (RFC 4648, section 4): the standard alphabet. Blanks and line breaks are ignored. The padding may be
/// missing, but must be valid if present.
/// Errors: Malformed; the message gives the position of an invalid character.
Result<std::string> decode_base64(std::string_view text);

/// Reads an image file inside JSON: base64, or a `data:` URI (RFC 2397) in base64. The media type is ignored.
/// Errors: Malformed for text that is neither; the errors of read_image_header() for the decoded file.
Result<ImageFile> read_embedded_image(const Input& input, const Limits& limits);

}  // namespace ccdt::api

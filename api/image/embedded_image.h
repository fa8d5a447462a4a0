#pragma once

#include <string>
#include <string_view>

#include "api/image/image_header.h"
#include "api/input/option_reader.h"
#include "api/run/options.h"
#include "core/result.h"

namespace ccdt::api {

/// Decodes base64 (RFC 4648, section 4): the standard alphabet, without line breaks; the padding may be left out
/// altogether, but what there is must be right.
/// Errors: Malformed, naming the first character that is wrong.
Result<std::string> decode_base64(std::string_view text);

/// Reads an image file inside JSON: base64, or a `data:` URI (RFC 2397) in base64, whose media type is not looked at.
/// Errors: Malformed for the text; those of read_image_header for what it holds.
Result<ImageFile> read_embedded_image(const Input& input, const Limits& limits);

}  // namespace ccdt::api

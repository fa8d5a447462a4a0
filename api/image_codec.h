#pragma once

#include <cstddef>
#include <string_view>

#include "core/halftone/tone.h"
#include "core/result.h"

namespace ccdt::api {

/// Tells by its first bytes whether an image file is of a format that is read: PNG, JPEG, WebP or TIFF.
/// Errors: Malformed if there are no bytes; Unsupported for any other format, naming those that are read.
Result<void> check_image(std::string_view bytes);

/// Decodes an image file to luminance in linear light.
///
/// Reads 1 to 16 bits a channel and floats; grey, RGB, palettes and CMYK, with or without alpha. Applies the
/// orientation that EXIF gives. Values are sRGB unless the file says that they are linear or names a gamma;
/// floats are linear. Colour profiles are not applied. Of several pictures in a file the first is read.
///
/// @param max_pixels  of the picture, told from its header before any pixel is read
/// Errors: those of check_image; LimitExceeded for too many pixels; Unusable for a broken or shortened file, and
/// for kinds of TIFF that are not read. One TIFF is read at a time, whatever the number of threads.
/// Needs little memory besides the picture, except where the file must be decoded as a whole: WebP, interlaced
/// PNG, progressive JPEG.
Result<Picture> decode_image(std::string_view bytes, std::size_t max_pixels);

}  // namespace ccdt::api

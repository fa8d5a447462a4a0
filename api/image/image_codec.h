// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/image/picture_reader.h"
#include "core/base/result.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Decodes an image file to luminance in linear light.
///
/// Reads 1 to 32 bits per channel and floats; grey, RGB, palettes, CMYK and Lab, with or without alpha. Applies the
/// orientation in EXIF or in the properties of an AVIF or HEIC, and the colour profile. Colours outside the gamut of
/// sRGB keep their luminance and lose saturation. Without a profile, values are sRGB unless the file declares them
/// linear or gives a gamma. Floats are linear. A broken profile is ignored. If a file has several pictures, the first
/// one is read; in an AVIF or HEIC, the primary item is read.
///
/// Errors: the errors of read_image_header(); Unusable for a broken or truncated file, and for kinds of TIFF, AVIF
/// and HEIC that are not supported, which the message names.
/// Needs little memory in addition to the picture, with two exceptions. Some files are decoded as a whole: WebP, GIF,
/// AVIF, HEIC, interlaced PNG, progressive JPEG. A profile needs tables and a copy of the file.
Result<Picture> decode_image(std::string_view bytes, const Reading& reading, const NewPlane& make_plane = new_plane);

/// Decodes an image file like decode_image(), but to red, green and blue. The three are equal if the file is grey.
Result<ColourPicture> decode_colour_image(std::string_view bytes, const Reading& reading,
                                          const NewPlane& make_plane = new_plane);

}  // namespace ccdt::api

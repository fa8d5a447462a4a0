// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>
#include <string_view>

#include "core/halftone/picture.h"
#include "core/result.h"

namespace ccdt::api {

/// Allocates a plane of `size` values, in the order of a picture's members; throws if it cannot.
using NewPlane = std::function<std::shared_ptr<float[]>(std::size_t size)>;

/// Parameters of reading a file.
struct Reading {
    Reading(std::size_t most, int side = 1) : max_pixels(most), reduce(side) {}

    static constexpr int kMostReduced = 4;

    std::size_t max_pixels;  ///< of the picture in the file; checked by its header before any pixel is read
    /// Side of the squares, 1 to kMostReduced pixels, each of which becomes one pixel of their mean light if the
    /// picture is opaque and consists of whole squares. Any other picture keeps its pixels.
    int reduce;
};

/// Allocates a plane in the memory of this process.
std::shared_ptr<float[]> new_plane(std::size_t size);

/// Decodes an image file to luminance in linear light.
///
/// Reads 1 to 16 bits per channel and floats; grey, RGB, palettes and CMYK, with or without alpha. Applies the
/// orientation that EXIF or an AVIF's own properties give, and the colour profile: colours that the primaries of sRGB
/// cannot show keep their luminance and lose saturation. Without a profile, values are sRGB unless the file declares
/// them linear or gives a gamma; floats are linear. A broken profile is ignored. If a file has several pictures, the
/// first is read; of an AVIF, the primary item.
///
/// @param make_plane  allocates the planes of the picture
/// Errors: those of read_image_header(); Unusable for a broken or truncated file, and for kinds of TIFF and AVIF that
/// are not supported. One TIFF is read at a time, whatever the number of threads.
/// Needs little memory besides the picture, except if the file must be decoded as a whole (WebP, GIF, AVIF, interlaced
/// PNG, progressive JPEG), or has a profile, which needs tables and a copy of the file.
Result<Picture> decode_image(std::string_view bytes, const Reading& reading, const NewPlane& make_plane = new_plane);

/// Decodes to red, green and blue, which are equal if the file is grey.
Result<ColourPicture> decode_colour_image(std::string_view bytes, const Reading& reading,
                                          const NewPlane& make_plane = new_plane);

/// Decoders: decode_image() and decode_colour_image(), or others that do the same elsewhere. They may poll the stop
/// token, and then fail with Stopped.
struct Decode {
    template <class AnyPicture>
    using To =
        std::function<Result<AnyPicture>(std::string_view bytes, const Reading& reading, const std::stop_token& stop)>;

    To<Picture> grey;
    To<ColourPicture> colour;
};

/// Returns decoders that run in the calling thread and ignore the stop token.
Decode decode_inline();

}  // namespace ccdt::api

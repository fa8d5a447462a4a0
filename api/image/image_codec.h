#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>
#include <string_view>

#include "core/halftone/picture.h"
#include "core/result.h"

namespace ccdt::api {

/// Gives memory for a plane of so many values, in the order of a picture's members; throws if it has none.
using NewPlane = std::function<std::shared_ptr<float[]>(std::size_t size)>;

/// How a file is read.
struct Reading {
    Reading(std::size_t most, int side = 1) : max_pixels(most), reduce(side) {}

    static constexpr int kMostReduced = 4;

    std::size_t max_pixels;  ///< of the file's picture, told from its header before any pixel is read
    /// Squares of so many pixels a side, 1 to kMostReduced, become one pixel of their mean light, if the picture is
    /// opaque and made of whole squares; else it comes as it is.
    int reduce;
};

/// Takes memory of this process.
std::shared_ptr<float[]> new_plane(std::size_t size);

/// Decodes an image file to luminance in linear light.
///
/// Reads 1 to 16 bits a channel and floats; grey, RGB, palettes and CMYK, with or without alpha. Applies the
/// orientation that EXIF gives, or an AVIF's own properties, and the colour profile: colours that the primaries of sRGB
/// cannot show keep their luminance and lose saturation. Without a profile values are sRGB unless the file says that
/// they are linear or names a gamma; floats are linear. A broken profile counts as none. Of several pictures in a file
/// the first is read, of an AVIF that which stands for the others.
///
/// @param make_plane  where the picture goes
/// Errors: those of read_image_header; Unusable for a broken or shortened file, and for kinds of TIFF and AVIF that
/// are not read. One TIFF is read at a time, whatever the number of threads.
/// Needs little memory besides the picture, except where the file must be decoded as a whole (WebP, GIF, AVIF,
/// interlaced PNG, progressive JPEG), and where it has a profile: for tables, and a copy of the file.
Result<Picture> decode_image(std::string_view bytes, const Reading& reading, const NewPlane& make_plane = new_plane);

/// Decodes to red, green and blue, which of a grey file are alike.
Result<ColourPicture> decode_colour_image(std::string_view bytes, const Reading& reading,
                                          const NewPlane& make_plane = new_plane);

/// Decoders: decode_image and decode_colour_image, or what does the same elsewhere. They may look at the token; told to
/// stop they fail with Stopped.
struct Decode {
    template <class AnyPicture>
    using To =
        std::function<Result<AnyPicture>(std::string_view bytes, const Reading& reading, const std::stop_token& stop)>;

    To<Picture> grey;
    To<ColourPicture> colour;
};

/// Decodes in this thread, which a stop does not end.
Decode decode_inline();

}  // namespace ccdt::api

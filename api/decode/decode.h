// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>
#include <string_view>

#include "api/image/picture_reader.h"
#include "api/surface/surface_reader.h"
#include "core/base/result.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Reads a mesh file by read_surface() and the pictures of its materials by decode_colour_image().
Result<SurfaceContents> read_surface_with_pictures(std::string_view bytes, const SurfaceHeader& header);

/// Decoders: decode_image(), decode_colour_image() and read_surface_with_pictures(), or functions that do the same in
/// another process. They may poll the stop token; after a stop, they fail with Stopped.
struct Decode {
    template <class AnyPicture>
    using To =
        std::function<Result<AnyPicture>(std::string_view bytes, const Reading& reading, const std::stop_token& stop)>;

    To<Picture> grey;
    To<ColourPicture> colour;
    std::function<Result<SurfaceContents>(std::string_view bytes, const SurfaceHeader& header,
                                          const std::stop_token& stop)>
        surface = {};  ///< empty where no mesh files are read
};

/// Returns decoders that run in the calling thread and ignore the stop token.
Decode decode_inline();

}  // namespace ccdt::api

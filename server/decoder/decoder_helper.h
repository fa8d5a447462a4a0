// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "api/image/image_codec.h"
#include "api/map/shapefile_reader.h"
#include "api/surface/surface_reader.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Decoding functions that run in the helper and its children.
struct Decoder {
    template <class AnyPicture>
    using To = std::function<Result<AnyPicture>(std::string_view file, const api::Reading& reading,
                                                const api::NewPlane& make_plane)>;

    /// Signature of api::read_shapefile.
    using ToMap = std::function<Result<void>(std::string_view archive, const api::ShapefileReading& reading,
                                             const api::TakeText& take)>;

    /// Signature of api::read_surface_with_pictures.
    using ToSurface =
        std::function<Result<api::SurfaceContents>(std::string_view file, const api::SurfaceHeader& header)>;

    To<Picture> grey;               ///< normally api::decode_image
    To<ColourPicture> colour;       ///< normally api::decode_colour_image
    std::function<void()> warm_up;  ///< initialises libraries before the first file; may be empty
    ToMap map = {};                 ///< empty: orders for shapefiles fail
    ToSurface surface = {};         ///< empty: orders for meshes fail
};

/// Turns the calling process into the parent of the helper. The helper receives orders, and forks a sandboxed child for
/// each one. The parent closes inherited files, waits for the helper, and ends with the helper's exit status.
///
/// The helper ends once the other end of `orders` is closed. Its children end with it, even if the helper is killed.
[[noreturn]] void run_decoder_helper(UniqueFd orders, const Decoder& decoder);

}  // namespace ccdt::server

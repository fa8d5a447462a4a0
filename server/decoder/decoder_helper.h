// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "api/image/image_codec.h"
#include "api/map/shapefile_reader.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Functions that run in the helper and its children.
struct Decoder {
    template <class AnyPicture>
    using To = std::function<Result<AnyPicture>(std::string_view file, const api::Reading& reading,
                                                const api::NewPlane& make_plane)>;

    /// Signature of api::read_shapefile.
    using ToMap = std::function<Result<void>(std::string_view archive, const api::ShapefileReading& reading,
                                             const api::TakeText& take)>;

    To<Picture> grey;               ///< as api::decode_image
    To<ColourPicture> colour;       ///< as api::decode_colour_image
    std::function<void()> warm_up;  ///< what these do but once; may be empty
    ToMap map = {};                 ///< empty: none is decoded
};

/// The helper: takes orders, and has each done by a child in the sandbox. The calling process only waits for the helper
/// and ends as it does; of the files that it has open it keeps the standard error.
///
/// The helper ends once the other end of `orders` is closed, and with it, however it ends, the children.
[[noreturn]] void run_decoder_helper(UniqueFd orders, const Decoder& decoder);

}  // namespace ccdt::server

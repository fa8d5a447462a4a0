// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/decode/decode.h"

#include "api/image/image_codec.h"

namespace ccdt::api {

Result<SurfaceContents> read_surface_with_pictures(std::string_view bytes, const SurfaceHeader& header) {
    return read_surface(bytes, header, [](std::string_view picture, std::size_t max_pixels) {
        return decode_colour_image(picture, max_pixels);
    });
}

Decode decode_inline() {
    return {[](std::string_view bytes, const Reading& reading, const std::stop_token&) {
                return decode_image(bytes, reading);
            },
            [](std::string_view bytes, const Reading& reading, const std::stop_token&) {
                return decode_colour_image(bytes, reading);
            },
            [](std::string_view bytes, const SurfaceHeader& header, const std::stop_token&) {
                return read_surface_with_pictures(bytes, header);
            }};
}

}  // namespace ccdt::api

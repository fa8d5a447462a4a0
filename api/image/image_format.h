// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace ccdt::api {

enum class ImageFormat { Png, Jpeg, WebP, Tiff, Gif, Bmp, Avif, Heic };

/// Returns the name of a format, such as "PNG".
constexpr std::string_view name_of(ImageFormat format) {
    constexpr auto kNames =
        std::to_array<std::string_view>({"PNG", "JPEG", "WebP", "TIFF", "GIF", "BMP", "AVIF", "HEIC"});
    return kNames[static_cast<std::size_t>(format)];
}

}  // namespace ccdt::api

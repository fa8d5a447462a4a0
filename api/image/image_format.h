// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::api {

enum class ImageFormat { Png, Jpeg, WebP, Tiff, Gif, Bmp, Avif };

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "api/halftone.h"
#include "api/output/json_writer.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the size of the drawn part of a picture: the whole picture, or with fit=cover the largest part, in its
/// middle, that has the aspect ratio of the drawing.
PictureSize drawn_part(const HalftoneRequest& request, PictureSize picture);

/// Returns the canvas of a drawing, or nothing if its size depends on the dots. The canvas shows the whole part,
/// stretched by up to half a pixel where a side is not a whole number of pixels.
///
/// Unless a request gives the size, a drawing for the screen is as large as fits into 1,280 x 800 pixels, but at least
/// 1,000 pixels long, within limits.max_pixels.
///
/// @param part  size of the drawn part of the picture
std::optional<Canvas> settled_canvas(const HalftoneRequest& request, PictureSize part, const Limits& limits);

/// Returns the name of the option that determines the size of a drawing, for errors about drawings that are too large.
std::string size_option(const HalftoneRequest& request);

}  // namespace ccdt::api

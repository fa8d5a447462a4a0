#pragma once

#include <optional>
#include <string>

#include "api/halftone.h"
#include "api/output/json_writer.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the size of the part of a picture that is drawn, from its middle: all of it, or with fit=cover the largest
/// part that has the aspect of the drawing.
PictureSize drawn_part(const HalftoneRequest& request, PictureSize picture);

/// Returns the canvas of a drawing whose size does not depend on its dots, or nothing if it does. The canvas shows the
/// whole part, stretched by up to half a pixel where its sides are no whole pixels.
///
/// Unless a size is asked for, a drawing for the screen is as large as fits into 1,280 x 800 pixels, but at least 1,000
/// pixels long, as far as limits.max_pixels allows it.
///
/// @param part  of the picture that is drawn
std::optional<Canvas> settled_canvas(const HalftoneRequest& request, PictureSize part, const Limits& limits);

/// Returns the name of the option that a drawing has its size from, to be told where it is too large.
std::string size_option(const HalftoneRequest& request);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "api/halftone/halftone_request.h"
#include "api/output/json_writer.h"
#include "api/output/page.h"
#include "core/base/result.h"
#include "core/halftone/dots/dots.h"

namespace ccdt::api {

/// Returns the size of the part of a picture that is drawn: usually the whole picture; with fit=cover the largest
/// centred part that has the aspect ratio of the drawing.
PictureSize drawn_part(const HalftoneRequest& request, PictureSize picture);

/// Returns the canvas of a drawing, or nothing if the size of the drawing depends on the dots. The canvas shows the
/// whole drawn part. If a side would not be a whole number of pixels, the picture is stretched by up to half a pixel.
///
/// If the request gives no size, a drawing for screens is as large as fits into 1,280 x 800 pixels. If its longer side
/// then has less than 1,000 pixels, as for a tall picture, it is enlarged to 1,000 pixels. The drawing never has more
/// than limits.max_pixels.
///
/// @param part  size of the drawn part of the picture
std::optional<Canvas> settled_canvas(const HalftoneRequest& request, PictureSize part, const Limits& limits);

/// Sets the width and the paper of the page of a request, as the function of the same name in api/output.
Result<void> place_on_paper(const HalftoneRequest& request, Page& page);

/// Returns the name of the option that determines the size of a drawing: `dpi`, `width`, `height` or `scale`. Errors
/// about a drawing that is too large name this option.
std::string size_option(const HalftoneRequest& request);

/// Checks that a drawing has at most limits.max_pixels pixels. Errors: LimitExceeded.
Result<void> check_pixels(const HalftoneRequest& request, const Canvas& canvas, const Limits& limits);

}  // namespace ccdt::api

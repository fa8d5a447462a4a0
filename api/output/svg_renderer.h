// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Renders an SVG document that this project has written, as a PNG file, by librsvg and cairo. Not for SVG of clients.
///
/// @param scale  pixels per user unit
/// Same input, same bytes, with the same fonts installed. Errors: Internal if the text is not SVG or memory runs out.
///
/// Why librsvg, although /analyze also answers SVG: clients may request the plot as PNG. Without librsvg the container
/// image would not be smaller: OpenImageIO needs OpenCV and FFmpeg, and these need librsvg, Pango, cairo and the font.
Result<std::string> render_svg(std::string_view svg, double scale);

}  // namespace ccdt::api

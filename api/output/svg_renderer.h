// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::api {

/// Renders an SVG document as a PNG file, by librsvg and cairo. The document must have been written by this project,
/// and not by a client.
///
/// @param scale  pixels per user unit
/// The same input gives the same bytes with the same fonts. Errors: Internal if the text is not SVG or memory runs out.
///
/// Why librsvg: clients may request the plot of /analyze as PNG. The container image would not be smaller without
/// librsvg, because OpenImageIO needs OpenCV and FFmpeg, which need librsvg, Pango, cairo and the font.
Result<std::string> render_svg(std::string_view svg, double scale);

}  // namespace ccdt::api

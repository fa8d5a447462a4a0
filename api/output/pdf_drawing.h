// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>

#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"
#include "api/output/page.h"

namespace ccdt::api {

/// Writes dots as a page of PDF that is as large as the drawing: discs, or the strokes of pens, and dots on both sides
/// of the tonal scale with their ground. All are shapes, none pixels. Inks are groups that mix as in SVG.
///
/// @param page   has a width in millimetres
/// @param hurry  stopped, the paths are longer
/// @param stop   stopped, it ends early, with nothing of use
/// Throws std::bad_alloc if memory runs out.
void write_pdf(std::span<const InkDots> inks, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& hurry, const std::stop_token& stop);
void write_map_pdf(const MapOfDots& map, const Palette& palette, const Page& page, const DrawingOptions& drawing,
                   Body& body, const std::stop_token& hurry, const std::stop_token& stop);

}  // namespace ccdt::api

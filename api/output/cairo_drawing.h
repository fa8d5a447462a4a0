// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/image/overlay.h"
#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/page.h"
#include "api/output/point_set.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Draws points with a figure as a picture, opaque and antialiased. Throws std::bad_alloc if memory runs out.
/// @param stop  once stopped, drawing ends early
/// Errors: NotAcceptable where Cairo is missing.
Result<DotImage> picture_of_map(const PointSet& points, const Palette& palette, const Page& page,
                                const std::stop_token& stop);

/// Writes dots as a PDF document of one page, which is as large as the drawing. Dots are discs or the strokes of pens.
/// A drawing by one field has a shape for each ink. The page has shapes only, no pixels. Each layer is a group; groups
/// are mixed with each other as in SVG.
///
/// @param page       must have a width in millimetres
/// @param path_stop  once stopped, the search for short paths ends early, so paths are longer
/// @param stop       once stopped, writing ends early and the output is incomplete
/// Throws std::bad_alloc if memory runs out.
void write_pdf(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop);

}  // namespace ccdt::api

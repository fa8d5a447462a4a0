// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/page.h"
#include "api/output/point_set.h"

namespace ccdt::api {

/// Writes dots as Encapsulated PostScript, with the shapes of write_pdf(). PostScript has neither transparency nor
/// mixing. Inks with names and the mixing Multiply are spot colours that overprint each other, so each has a printing
/// plate of its own; cyan, magenta, yellow and black are those of the printer. Other inks cover what is below them.
///
/// @param page       must have a width in millimetres
/// @param path_stop  once stopped, the search for short paths ends early, so paths are longer
/// @param stop       once stopped, writing ends early and the output is incomplete
/// Source: PostScript Language Reference, third edition; Encapsulated PostScript File Format Specification 3.0.
void write_eps(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop);

}  // namespace ccdt::api

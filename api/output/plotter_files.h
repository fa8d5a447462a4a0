// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/output/body.h"
#include "api/output/plot.h"

namespace ccdt::api {

// Writers of plots in the languages of machines. Pages have a width in millimetres; the origin is the lower left corner
// of the page, and y runs up. Discs are touches of the pen, but circles in DXF.

/// Writes HPGL, in plotter units of 1/40 mm; each pen is selected by its number from 1.
void write_hpgl(const Plot& plot, Body& body, const std::stop_token& stop);

/// Writes G-code in millimetres and absolute coordinates. A dwell follows each command that moves the pen; the program
/// pauses (M0) for a change of pens.
void write_gcode(const Plot& plot, Body& body, const std::stop_token& stop);

/// Writes DXF R12, in millimetres, with a layer for each pen: circles, points for touches, and polylines.
void write_dxf(const Plot& plot, Body& body, const std::stop_token& stop);

}  // namespace ccdt::api

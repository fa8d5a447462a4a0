// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/output/body.h"
#include "api/output/plot.h"

namespace ccdt::api {

// Writers of plots in the languages of machines. Pages must have a width in millimetres. The origin is the lower left
// corner of the page, and the y axis points up. Dots in the style Fill are touches of the pen; in DXF they are circles.

/// Writes HPGL. Coordinates are in plotter units of 1/40 mm. Pens are numbered from 1.
void write_hpgl(const Plot& plot, Body& body, const std::stop_token& stop);

/// Writes G-code in millimetres and absolute coordinates. A dwell follows each command that raises or lowers the pen.
/// The written program pauses (M0) before each change of pens.
void write_gcode(const Plot& plot, Body& body, const std::stop_token& stop);

/// Writes DXF R12, in millimetres, with a layer for each pen. The entities are circles, polylines, and points, which
/// are touches of the pen.
void write_dxf(const Plot& plot, Body& body, const std::stop_token& stop);

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <string>

#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/page.h"
#include "api/output/point_set.h"
#include "core/geometry/point.h"
#include "core/halftone/dots/dots.h"

namespace ccdt::api {

/// Returns the canvas that shows a box at a scale. Sides are clamped to at least one pixel and at most the largest int.
/// @param scale  > 0
Canvas canvas_of(const Box& box, double scale);

/// Returns whether a canvas has at most `max_pixels` pixels.
bool fits(const Canvas& canvas, std::size_t max_pixels);

/// Returns the largest scale, up to `wished`, at which a box has at most `max_pixels` pixels.
/// @param wished      > 0, finite
/// @param max_pixels  >= 1
double fitting_scale(const Box& box, double wished, std::size_t max_pixels);

/// Writes dots as SVG. If the page has a width in millimetres, user units are millimetres; otherwise they are the
/// units of the points. The origin is the upper left corner of the page. Unless `page.along_path` is false, the dots of
/// each group are ordered along a short path. The element `desc` gives the length of this path, and the length in the
/// original order. If dots have ranks, their circles have the attribute `data-rank`. The paper is drawn as a shape only
/// if dots are discs, because a pen would draw this shape, too.
///
/// Layers with names are layers as Inkscape and programs for plotters understand them, so that pens can be changed
/// between layers. The ids of layers are `layer1`, `layer2` and so on. The labels of layers have no digits, because
/// programs for plotters read digits in a label as the layer's number.
///
/// If points are grouped by features, even a single class is a layer, and each layer has a group for each feature. The
/// id of a group is `feature-2` for the feature with index 2, or `class-1-feature-2` if classes have names.
///
/// A drawing by one field has a path for each ink. Inks with names are layers.
///
/// @param points     the radius of dots must be at most a small multiple of the page's longer side
/// @param path_stop  once stopped, the search for short paths ends early, so paths are longer; output begins after the
///                   search
/// @param stop       once stopped, writing ends early and the output is incomplete
void write_svg(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop = {}, const std::stop_token& stop = {});

/// Draws dots with antialiasing. On a torus, dots that cross the border reappear at the opposite side, so the picture
/// tiles.
///
/// @param radius  radius of the dots, in the units of the points; at most a small multiple of the page's longer side
/// @param stop    once stopped, drawing ends early and dots are missing
Raster draw_points(std::span<const Point> points, const Page& page, double radius, const std::stop_token& stop = {});

}  // namespace ccdt::api

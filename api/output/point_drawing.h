// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <string>

#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"
#include "api/output/page.h"
#include "core/geometry/point.h"
#include "core/halftone/dots.h"

namespace ccdt::api {

/// Makes the canvas that shows a box at a scale, at least a pixel each way and at most as many as an int can tell.
/// @param scale  > 0
Canvas canvas_of(const Box& box, double scale);

/// Tells whether a canvas has that many pixels at most.
bool fits(const Canvas& canvas, std::size_t max_pixels);

/// Finds the largest scale, up to one that is wished for, at which a box has that many pixels at most.
/// @param wished      > 0, finite
/// @param max_pixels  >= 1
double fitting_scale(const Box& box, double wished, std::size_t max_pixels);

/// Writes dots as SVG. If the page has a width in millimetres, user units are millimetres; otherwise they are the
/// units of the points. The origin is the upper left corner of the page. The dots of each ink are ordered along a
/// short path, and the element `desc` gives its length and the length in the original order. Circles of dots with
/// ranks have them as `data-rank`. The paper is drawn for discs only, because a pen would draw it, too.
///
/// Inks with names are layers for Inkscape and programs for plotters, so that pens can be changed between them. Their
/// ids are `layer1`, `layer2` and so on. Their labels have no digits, because those programs take digits for the
/// number.
///
/// Dots on both sides of the tonal scale are three layers: ink dots, black ground, paper dots. With several channels,
/// each channel is a layer of these three.
///
/// @param inks     with the radius of their dots: at most a small multiple of the page's longer side
/// @param palette  the palette of the inks
/// @param hurry    once stopped, the paths are longer; no output is written before all paths are found
/// @param stop     once stopped, writing ends early and the output is useless
void write_svg(std::span<const InkDots> inks, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& hurry = {}, const std::stop_token& stop = {});

/// Writes the dots of a map as SVG, as write_svg() does: in each class, which is a layer, a group for each feature,
/// whose id is `feature-` and the index of the feature, of classes with names with the class' number in front. Paths
/// are short within a group.
void write_map_svg(const MapOfDots& map, const Palette& palette, const Page& page, const DrawingOptions& drawing,
                   Body& body, const std::stop_token& hurry = {}, const std::stop_token& stop = {});

/// Draws dots antialiased; on a torus they come in again where they leave it, so that the picture tiles.
///
/// @param radius  of the dots, in the points' units; at most a few of the page's longer side
/// @param stop    stopped, it ends early, with nothing of use
Raster draw_points(std::span<const Point> points, const Page& page, double radius, const std::stop_token& stop = {});

}  // namespace ccdt::api

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

/// Writes dots as SVG, those of each ink ordered along a short path, for the pen of a plotter, if the page has them so;
/// circles of dots with ranks have these as `data-rank`. User units are
/// millimetres if the page has a width in these, else the points' units; the origin is the page's upper left corner,
/// and the paper is drawn for discs only, as a pen would draw it, too. The element `desc` tells how long a path is, and how long
/// it was. Inks with names are layers as Inkscape and programs for plotters know them, so that pens are changed between
/// them: their ids are `layer1`, `layer2` and so on, and their labels have no digits, which would count as a number.
///
/// Dots on both sides of the tonal scale are three layers: ink dots, black ground, paper dots; of several channels each
/// is a layer of these three.
///
/// @param inks     with the radius of their dots: at most a few of the page's longer side
/// @param palette  that of the inks
/// @param hurry    stopped, the paths are longer; all are there before anything is handed on
/// @param stop     stopped, it ends early, with nothing of use
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

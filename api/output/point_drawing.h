#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/geometry/point.h"
#include "core/halftone/dots.h"
#include "core/result.h"

namespace ccdt::api {

/// How SVG draws a dot.
enum class DotStyle {
    Fill,    ///< a disc
    Stroke,  ///< a stroke as wide as the dot and next to no length, for plotters: the pen goes down and up
};

/// Options of drawings, as they are asked for.
struct DrawingOptions {
    std::optional<double> width_mm;  ///< of the page; none: only pixels are told
    DotStyle style = DotStyle::Fill;
};

Result<void> read_width_mm(const Input& input, DrawingOptions& options);
Result<void> read_style(const Input& input, DrawingOptions& options);

/// A sheet that shows a box all over.
struct Page {
    Box box;                ///< in the points' units; its sides as those of a Domain
    bool y_up = false;      ///< the points' y runs up; on the page it always runs down
    bool periodic = false;  ///< the box is a torus
    Canvas canvas;          ///< its size in pixels, its scale in pixels per unit of the points
    std::optional<double> width_mm;
};

/// The canvas that shows a box at a scale, at least a pixel each way and at most as many as an int can tell.
/// @param scale  > 0
Canvas canvas_of(const Box& box, double scale);

/// Whether it has that many pixels at most.
bool fits(const Canvas& canvas, std::size_t max_pixels);

/// The largest scale, up to one that is wished for, at which a box has that many pixels at most.
/// @param wished      > 0, finite
/// @param max_pixels  >= 1
double fitting_scale(const Box& box, double wished, std::size_t max_pixels);

/// Writes dots as SVG, ordered along a short path, for the pen of a plotter. User units are millimetres if the page has
/// a width in these, else the points' units; the origin is the page's upper left corner, and the paper is drawn for
/// discs only, as a pen would draw it, too. A <desc> tells how long the path is, and how long it was.
///
/// @param radius  of the dots, in the points' units; at most a few of the page's longer side
/// @param hurry   stopped, the path is longer
/// @param stop    stopped, it ends early, with nothing of use
std::string write_svg(std::span<const Point> points, const Page& page, double radius, DotStyle style, const Inks& inks,
                      const std::stop_token& hurry = {}, const std::stop_token& stop = {});

/// The dots of an ink.
struct DotLayer {
    std::string name;
    Colour colour;
    std::span<const Point> points;
    double radius = 0;  ///< in the points' units
};

/// What the layers of a drawing are drawn on, and how they mix.
struct LayerGround {
    Colour paper = kWhite;
    bool additive = false;  ///< layers add their light; else each multiplies what is below it
};

/// The same in layers as Inkscape and programs for plotters know them, each along a path of its own, so that pens are
/// changed between them.
std::string write_svg(std::span<const DotLayer> layers, const Page& page, DotStyle style, const LayerGround& ground,
                      const std::stop_token& hurry = {}, const std::stop_token& stop = {});

/// Draws dots antialiased; on a torus they come in again where they leave it, so that the picture tiles.
///
/// @param radius  of the dots, in the points' units; at most a few of the page's longer side
/// @param stop    stopped, it ends early, with nothing of use
Raster draw_points(std::span<const Point> points, const Page& page, double radius, const std::stop_token& stop = {});

}  // namespace ccdt::api

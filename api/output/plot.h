// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "api/input/drawing_options.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"
#include "api/output/page.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt::api {

/// Dots that a pen draws one after the other.
struct PenRun {
    std::span<const Point> points;
    std::vector<std::uint32_t> path;  ///< order of the points
};

/// Strokes of one pen, in user units of the page.
struct Pen {
    std::string label;  ///< as pen_labels() makes it
    Colour colour;
    double radius = 0;          ///< of its dots
    double width = 0;           ///< of its strokes
    std::vector<Point> stroke;  ///< that it draws for a dot, from the centre; one point: it touches the paper
    std::vector<PenRun> runs;
};

/// All strokes of a drawing: what SVG and the formats of plotters write, each in its own language.
struct Plot {
    const Page& page;
    DotStyle style;
    Plotter plotter;
    std::vector<Pen> pens;

    /// Estimates how long a plotter draws: it moves at one speed, and lifts its pen between strokes.
    /// Meaningful on pages that have a width in millimetres.
    double seconds() const;
};

/// Ink that pens are to put on a page.
struct PlotInk {
    double area = 0;    ///< mm2 that dots of all pens cover
    double spread = 0;  ///< integral of the square root of each pen's share of the page, mm2
};

/// Estimates how many dots a plotter draws in a time, as Plot::seconds() has it. The path through n dots, whose density
/// is in proportion to the share c that they cover, is about sqrt(n) * integral of sqrt(c) / sqrt(integral of c) long
/// (Beardwood, Halton and Hammersley 1959; the factor of 1 is that of short_path() on blue noise).
/// @param radius  of the dots in millimetres; none: such that they cover the area
/// @returns       whole, >= 0
double dots_in(double seconds, const PlotInk& ink, std::optional<double> radius, const DrawingOptions& drawing);

/// Turns of a spiral, or circles, that fill a dot at most.
inline constexpr int kMostTurns = 50;

/// Draws a dot with a pen that is finer than it: Circles or Spiral, as a polyline from the centre of the dot. Turns are
/// at most a pen's width apart, and the polyline keeps to them within a fiftieth of it.
/// @param radius  at most kMostTurns pens
/// @returns       one point for other styles, and for dots that are no wider than the pen
std::vector<Point> dot_stroke(DotStyle style, double radius, double pen);

/// Checks that a pen is not so fine that it would take more than kMostTurns to fill a dot.
/// @param radius  of the dots, in the points' units
/// @param field   of the option
/// Errors: Unusable.
Result<void> check_pen(const DrawingOptions& drawing, double radius, const Page& page, const std::string& field);

/// Checks that a page in millimetres has sides that machines and readers of files have room for.
/// @param field  of the option width_mm
/// Errors: Unusable.
Result<void> check_sides(const Page& page, const std::string& field);

/// Plans the strokes of dots: each ink is a pen; of a map each class, with a run for each feature.
/// Page, points and inks must outlive the plot.
/// @param hurry  stopped, the paths are longer
Plot plot_of(std::span<const InkDots> inks, const Page& page, const DrawingOptions& drawing,
             const std::stop_token& hurry);
Plot plot_of(const MapOfDots& map, const Page& page, const DrawingOptions& drawing, const std::stop_token& hurry,
             const std::stop_token& stop);

/// Draws a run in a medium, which has `bool goes_on()`, asked now and then, and `begin(Point)`, `line_to(Point)` and
/// `end()` for each stroke; one without line_to() is a touch. Points are on the page, from its upper left corner.
template <class Medium>
void trace(const Plot& plot, const Pen& pen, const PenRun& run, Medium& medium) {
    constexpr std::size_t kBetween = 1'000;
    const Placing place(plot.page, plot.page.unit());
    const bool joined = plot.style == DotStyle::Path;
    for (std::size_t i = 0; i < run.path.size(); ++i) {
        if (i % kBetween == 0 && !medium.goes_on()) return;
        const Point centre = place(run.points[run.path[i]]);
        if (joined && i > 0) {
            medium.line_to(centre);
        } else {
            medium.begin(centre + pen.stroke.front());
            for (std::size_t k = 1; k < pen.stroke.size(); ++k) medium.line_to(centre + pen.stroke[k]);
        }
        if (!joined || i + 1 == run.path.size()) medium.end();
    }
}

}  // namespace ccdt::api

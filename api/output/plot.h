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
#include "api/output/page.h"
#include "api/output/point_set.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Dots that a pen draws one after the other.
struct PenRun {
    std::span<const Point> points;
    /// Indices of the points, in the order in which they are drawn. The path of a closed line ends with its first
    /// index.
    std::vector<std::uint32_t> path;
};

/// Strokes of one pen, in user units of the page.
struct Pen {
    std::string label;  ///< result of pen_labels()
    Colour colour;
    double radius = 0;  ///< radius of the pen's dots
    double width = 0;   ///< width of the pen's strokes
    /// Polyline that the pen draws for each dot, relative to the dot's centre. One point: the pen only touches the
    /// paper.
    std::vector<Point> stroke;
    std::vector<PenRun> runs;
};

/// All strokes of a drawing, independent of the file format (SVG, PDF and the formats of plotters).
struct Plot {
    const Page& page;
    DotStyle style;
    bool closed;  ///< whether lines end where they start
    Plotter plotter;
    std::optional<double> tone;  ///< as PointSet::tone
    std::vector<Pen> pens;

    /// Estimates the length of a plotter's path and the time that it takes. The model: the pen moves at constant speed,
    /// and is lifted between strokes. Meaningful only if the page has a width in millimetres.
    PlotSize size() const;

    /// Describes the plot in words without capitals, brackets and characters that controllers of machines interpret,
    /// such as "900 dots, pen 0.3 mm, path 12.3 m, 4.2 min, tone 0.98".
    std::string description() const;
};

/// Area of the ink that pens draw on a page.
struct PlotInk {
    double area = 0;    ///< area that the dots of all pens cover, mm2
    double spread = 0;  ///< integral of sqrt(coverage), summed over the pens, mm2
};

/// Estimates the radius with which dots cover an area together, although they overlap.
double covering_radius(double area, double dots);

/// Estimates the number of dots that a plotter draws in a given time, by the model of Plot::size(). If the density
/// of n dots is proportional to the coverage c, the length of a short path through the dots is about sqrt(n) *
/// (integral of sqrt(c)) / sqrt(integral of c). Source: Beardwood, Halton and Hammersley 1959; the constant factor
/// of this length is 1 to 1.02 for short_path() on at least 1,000 dots of blue noise.
/// @param radius  radius of the dots in millimetres; none: chosen such that all dots together cover `ink.area`
/// @returns       an integer >= 0
double dots_in(double seconds, const PlotInk& ink, std::optional<double> radius, const DrawingOptions& drawing);

/// Maximum number of circles, or turns of a spiral, that fill a dot.
inline constexpr int kMaxTurns = 50;

/// Returns the polyline with which a pen fills a dot in the styles Circles and Spiral, relative to the dot's centre.
/// Neighbouring circles or turns are at most one width of the pen apart. The polyline deviates from the exact curve by
/// at most a fiftieth of the pen's width.
/// @param radius  radius of the dot; at most kMaxTurns widths of the pen
/// @param pen     width of the pen, in the unit of `radius`
/// @returns       one point, the centre, for other styles and for dots that are not wider than the pen
std::vector<Point> dot_stroke(DotStyle style, double radius, double pen);

/// Checks that a pen is wide enough to fill a dot with at most kMaxTurns circles or turns.
/// @param radius  radius of the dots, in the units of the points
/// @param field   Error::field of errors, which are about the option `pen`
/// Errors: Unusable.
Result<void> check_pen(const DrawingOptions& drawing, double radius, const Page& page, const std::string& field);

/// Checks that the sides of a page are within the limits of machines and of programs that read the files.
/// @param field  Error::field of errors, which are about the option `width_mm`
/// Errors: Unusable.
Result<void> check_sides(const Page& page, const std::string& field);

/// Plans the strokes of dots. Each layer has a pen. The dots of a layer are one run or, if they are grouped by
/// features, one run for each feature. `page` and `points` must outlive the plot.
/// @param path_stop  once stopped, the search for short paths ends early, so paths are longer
/// @param stop       once stopped, planning ends early and runs are missing
Plot plot_of(const PointSet& points, const Page& page, const DrawingOptions& drawing, const std::stop_token& path_stop,
             const std::stop_token& stop = {});

/// Draws the registration marks of a page with an object like that of trace().
template <class Medium>
void trace_marks(const Page& page, Medium& medium) {
    for (const auto& [from, to] : page.marks()) {
        medium.begin(from);
        medium.line_to(to);
        medium.end();
    }
}

/// Draws a run with an object `medium`. For each stroke, calls medium.begin(Point), medium.line_to(Point) for the
/// further points, and medium.end(). A stroke without line_to() is a touch of the pen. Calls medium.should_continue()
/// from time to time, and returns early if the result is false. Points are relative to the upper left corner of the
/// page, in user units.
template <class Medium>
void trace(const Plot& plot, const Pen& pen, const PenRun& run, Medium& medium) {
    constexpr std::size_t kCheckInterval = 1'000;
    const PageMapping position(plot.page, plot.page.unit());
    const bool joined = plot.style == DotStyle::Path;
    for (std::size_t i = 0; i < run.path.size(); ++i) {
        if (i % kCheckInterval == 0 && !medium.should_continue()) return;
        const Point centre = position(run.points[run.path[i]]);
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

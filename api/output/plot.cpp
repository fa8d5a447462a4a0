// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "api/output/pen_labels.h"
#include "api/text/numbers.h"
#include "core/base/elementary.h"
#include "core/points/tour/short_path.h"

namespace ccdt::api {
namespace {

/// Returns PenRun::path.
std::vector<std::uint32_t> path_of(std::span<const Point> points, const Page& page, bool closed,
                                   const std::stop_token& path_stop) {
    std::vector<std::uint32_t> path(points.size());
    if (page.along_path) {
        path = closed ? short_tour(points, path_stop) : short_path(points, path_stop);
    } else {
        std::iota(path.begin(), path.end(), 0U);
    }
    if (closed && path.size() > 1) path.push_back(path.front());
    return path;
}

double distance(Point a, Point b) {
    return std::sqrt(dot(a - b, a - b));
}

/// Appends a full turn around the origin to a stroke.
/// @param from, to  radii at the beginning and at the end of the turn
/// @param pen       width of the pen, which determines the accuracy
void append_turn(std::vector<Point>& stroke, double from, double to, double pen) {
    constexpr double kTolerance = 1.0 / 50;
    constexpr int kMinCorners = 8;
    const double outer = std::max(from, to);
    const double step = 2 * elementary::acos(std::max(1 - kTolerance * pen / outer, 0.0));
    const int count = std::max(static_cast<int>(std::ceil(2 * std::numbers::pi / step)), kMinCorners);
    for (int i = 1; i <= count; ++i) {
        const double share = static_cast<double>(i) / count;
        const double angle = 2 * std::numbers::pi * share;
        const double radius = from + (to - from) * share;
        stroke.push_back({radius * elementary::cos(angle), radius * elementary::sin(angle)});
    }
}

std::vector<Point> spiral(double reach, double pen) {
    std::vector<Point> stroke = {{0, 0}};
    const int turns = static_cast<int>(std::ceil(reach / pen));
    for (int turn = 0; turn < turns; ++turn) append_turn(stroke, reach * turn / turns, reach * (turn + 1) / turns, pen);
    append_turn(stroke, reach, reach, pen);
    return stroke;
}

/// Returns concentric circles, the innermost of which covers the centre.
/// @param reach  radius of the outermost circle
/// @param pen    width of the pen
std::vector<Point> circles(double reach, double pen) {
    const double inner = std::min(reach, pen / 2);
    const int steps = static_cast<int>(std::ceil((reach - inner) / pen));
    std::vector<Point> stroke;
    for (int i = 0; i <= steps; ++i) {
        const double radius = steps == 0 ? inner : inner + (reach - inner) * i / steps;
        stroke.push_back({radius, 0});
        append_turn(stroke, radius, radius, pen);
    }
    return stroke;
}

Pen make_pen(std::string label, const Colour& colour, double radius, const DrawingOptions& drawing) {
    const double width = drawing.has_pen_width() ? drawing.pen_mm : 2 * radius;
    return {std::move(label), colour, radius, width, dot_stroke(drawing.style, radius, drawing.pen_mm), {}};
}

double length(std::span<const Point> stroke) {
    double sum = 0;
    for (std::size_t i = 1; i < stroke.size(); ++i) sum += distance(stroke[i - 1], stroke[i]);
    return sum;
}

/// Estimates the time that a plotter takes to draw a number of dots, in seconds, by the model of dots_in().
double seconds_for(double dots, const PlotInk& ink, std::optional<double> radius, const DrawingOptions& drawing) {
    // Factor of the length of the path. Most paths are slightly shorter, so few drawings take too long.
    constexpr double kPath = 1.02;
    const double each = radius.value_or(covering_radius(ink.area, dots));
    if (drawing.has_turns() && each > kMaxTurns * drawing.pen_mm) return std::numeric_limits<double>::infinity();
    const double drawn = length(dot_stroke(drawing.style, each, drawing.pen_mm));
    const double lifts = drawing.style == DotStyle::Path ? 1 : dots;
    const double moved = kPath * ink.spread * std::sqrt(dots / ink.area) + dots * drawn;
    const bool is_touch = drawing.style != DotStyle::Path && !(drawn > 0);
    return moved / drawing.plotter.speed + drawing.plotter.pauses(is_touch) * lifts;
}

}  // namespace

std::vector<Point> dot_stroke(DotStyle style, double radius, double pen) {
    const double reach = radius - pen / 2;  // radius of the outermost circle that the centre of the pen draws
    if (!(reach > 0)) return {{0, 0}};
    if (style == DotStyle::Spiral) return spiral(reach, pen);
    if (style == DotStyle::Circles) return circles(reach, pen);
    return {{0, 0}};
}

Result<void> check_pen(const DrawingOptions& drawing, double radius, const Page& page, const std::string& field) {
    if (!drawing.has_turns() || radius * page.unit() <= kMaxTurns * drawing.pen_mm) return {};
    std::string message = "pen is ";
    append_shortest(message, drawing.pen_mm);
    message += " mm wide, but dots have a radius of ";
    append_rounded(message, radius * page.unit(), 2);
    message += " mm: filling a dot would take more than " + std::to_string(kMaxTurns) +
               " turns; choose a wider pen or more sites";
    return failure(ErrorCode::Unusable, std::move(message), field);
}

Result<void> check_sides(const Page& page, const std::string& field) {
    constexpr double kMinSide = 0.01, kMax = 100'000;
    const Point size = page.size();
    if (std::min(size.x, size.y) >= kMinSide && std::max(size.x, size.y) <= kMax) return {};
    std::string message = "width_mm makes a page of ";
    append_shortest(message, size.x);
    message += " x ";
    append_shortest(message, size.y);
    message += " mm; in this format, its sides must be from 0.01 to 100000 mm";
    return failure(ErrorCode::Unusable, std::move(message), field);
}

PlotSize Plot::size() const {
    const double unit = page.unit();
    const PageMapping position(page, unit);
    const std::vector<MarkLine> marks = page.marks();
    PlotSize size;
    double pauses = 0;
    for (const Pen& pen : pens) {
        size.pen_mm = std::max(size.pen_mm, pen.width);
        const double drawn = length(pen.stroke);
        std::optional<Point> before;
        std::vector<Point> before_dots;
        for (const auto& [from, to] : marks) before_dots.insert(before_dots.end(), {from, to});
        if (!marks.empty() && !pen.runs.front().path.empty())
            before_dots.push_back(position(pen.runs.front().points[pen.runs.front().path.front()]));
        size.path_mm += length(before_dots);
        pauses += static_cast<double>(marks.size()) * plotter.pauses(false);
        const double each = plotter.pauses(style != DotStyle::Path && !(drawn > 0));
        for (const PenRun& run : pen.runs) {
            for (const std::uint32_t i : run.path) {
                if (before) size.path_mm += unit * distance(*before, run.points[i]);
                before = run.points[i];
            }
            const auto dots = static_cast<double>(run.path.size());
            size.path_mm += dots * drawn;
            pauses += each * (style == DotStyle::Path ? std::min(dots, 1.0) : dots);
        }
    }
    size.seconds = size.path_mm / plotter.speed + pauses;
    return size;
}

std::string Plot::description() const {
    constexpr double kMetre = 1000, kMinute = 60;
    std::size_t dots = 0;
    for (const Pen& pen : pens) {
        for (const PenRun& run : pen.runs) dots += run.points.size();
    }
    const PlotSize drawn = size();
    std::string text = std::to_string(dots) + " dots, pen ";
    append_fixed(text, drawn.pen_mm, 2);
    append_fixed(text += " mm, path ", drawn.path_mm / kMetre, 2);
    append_fixed(text += " m, ", drawn.seconds / kMinute, 1);
    text += " min";
    if (tone) append_fixed(text += ", tone ", *tone, 2);
    return text;
}

double covering_radius(double area, double dots) {
    constexpr double kOverlaps = 1.2;  // typical total area of dots, divided by the area that they cover together
    return std::sqrt(kOverlaps * area / dots / std::numbers::pi);
}

double dots_in(double seconds, const PlotInk& ink, std::optional<double> radius, const DrawingOptions& drawing) {
    constexpr int kSteps = 64;
    double fits = 0, too_many = 1e9;
    for (int step = 0; step < kSteps && std::floor(fits) != std::floor(too_many); ++step) {
        const double dots = (fits + too_many) / 2;
        (seconds_for(dots, ink, radius, drawing) <= seconds ? fits : too_many) = dots;
    }
    return std::floor(fits);
}

Plot plot_of(const PointSet& points, const Page& page, const DrawingOptions& drawing, const std::stop_token& path_stop,
             const std::stop_token& stop) {
    const std::vector<std::string> labels = pen_labels(points.inks());
    Plot plot{page, drawing.style, drawing.closed, drawing.plotter, points.tone, {}};
    for (std::size_t i = 0; i < points.layers.size(); ++i) {
        const InkDots& layer = points.layers[i];
        Pen& pen = plot.pens.emplace_back(make_pen(labels[i], layer.ink.colour, layer.radius * page.unit(), drawing));
        points.for_groups(layer, [&](std::uint32_t, std::size_t first, std::size_t count) {
            if (stop.stop_requested()) return;
            const auto group = std::span<const Point>(layer.dots.points).subspan(first, count);
            pen.runs.push_back({group, layer.path.empty() ? path_of(group, page, plot.closed, path_stop)
                                                          : std::vector(layer.path.begin(), layer.path.end())});
        });
    }
    return plot;
}

}  // namespace ccdt::api

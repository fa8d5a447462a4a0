// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_drawing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "api/output/pen_labels.h"
#include "api/output/plot.h"
#include "api/output/ring_curves.h"
#include "api/output/svg_map.h"
#include "api/output/svg_page.h"
#include "api/text/numbers.h"
#include "core/base/elementary.h"
#include "core/points/tour/short_path.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kChunk = 10'000;  // dots between two checks of the stop token; libxml2 reads paths of up to 10 MB
constexpr std::size_t kTypicalDotBytes = 64;  // typical number of bytes of a dot

/// Attributes of a drawing with layers. With the style `isolation:isolate`, layers are mixed only with each other, not
/// with the document around the drawing.
constexpr std::string_view kLayers =
    R"( xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" style="isolation:isolate")";

/// The points of a path, in the order of the path, in coordinates of the page.
class PlacedPath {
public:
    /// All arguments must outlive this object.
    /// @param ranks  ranks of the points; may be empty
    PlacedPath(std::span<const Point> points, std::span<const std::uint32_t> ranks, std::span<const std::uint32_t> path,
               const PageMapping& mapping)
        : points_(points), ranks_(ranks), path_(path), mapping_(mapping) {}

    std::size_t size() const { return path_.size(); }
    Point operator[](std::size_t i) const { return mapping_(points_[path_[i]]); }

    bool are_ranked() const { return !ranks_.empty(); }
    std::uint32_t rank(std::size_t i) const { return ranks_[path_[i]]; }

    double length() const {
        double sum = 0;
        for (std::size_t i = 1; i < size(); ++i) {
            const Point step = (*this)[i - 1] - (*this)[i];
            sum += std::sqrt(dot(step, step));
        }
        return sum;
    }

private:
    std::span<const Point> points_;
    std::span<const std::uint32_t> ranks_;
    std::span<const std::uint32_t> path_;
    const PageMapping& mapping_;
};

/// SVG document of dots that is being written.
class DotDocument {
public:
    /// @param page        must outlive this object
    /// @param attributes  additional attributes of the root element
    DotDocument(const Page& page, std::size_t dots, std::string_view attributes, Body& body)
        : body_(body), unit_(page.unit()), page_(page), decimals_(svg_decimals(page)) {
        body_.expect(dots * kTypicalDotBytes);
        begin_svg(page, attributes, body_);
    }

    /// Returns the number of user units per unit of the points.
    double unit() const { return unit_; }

    /// @param text  must not contain two hyphens in a row
    void comment(std::string_view text) { write("<!-- ", text, " -->\n"); }

    void describe(std::size_t dots, double radius, double path, double original, std::string_view unit) {
        write("<desc>", std::to_string(dots), " dots along a path of ", path, unit, "; in their original order it is ",
              original, unit, "; their radius is ", radius, unit, "</desc>\n");
    }

    void describe(std::size_t sites) {
        write("<desc>", std::to_string(sites), " dots and holes of one field</desc>\n");
    }

    void paper(const Colour& colour) {
        if (colour.transparent) return;
        const Box area = page_.drawing();
        write("<rect ");
        if (page_.sheet) write(R"(x=")", area.min.x, R"(" y=")", area.min.y, R"(" )");
        write(R"(width=")", area.width(), R"(" height=")", area.height(), R"(" fill=")", hexadecimal(colour), "\"/>\n");
    }

    void marks(const Colour& colour) {
        const std::vector<MarkLine> lines = page_.marks();
        if (lines.empty()) return;
        write(R"(<path fill="none" stroke=")", hexadecimal(colour), R"(" stroke-width=")", kMarkWidth, R"(" d=")");
        for (const auto& [from, to] : lines) write("M", from.x, " ", from.y, "L", to.x, " ", to.y);
        write("\"/>\n");
    }

    /// Begins a layer of the drawing. Programs that change pens between layers read the layer's number in its id.
    /// @param number  from 1, in drawing order
    /// @param blend   blend mode of CSS; empty: the layer hides the layers below it
    void begin_layer(std::size_t number, std::string_view label, std::string_view blend) {
        write(R"(<g id="layer)", std::to_string(number), R"(" inkscape:groupmode="layer" inkscape:label=")",
              escaped(label), "\"");
        if (!blend.empty()) write(R"( style="mix-blend-mode:)", blend, "\"");
        write(">\n");
    }

    void begin_group(std::string_view id) { write(R"(<g id=")", id, "\">\n"); }

    void end_layer() { write("</g>\n"); }

    /// Draws discs of equal size, or the strokes of a pen.
    void dots(const Plot& plot, const Pen& pen, const PenRun& run, const PlacedPath& centres,
              const std::stop_token& stop) {
        if (plot.style != DotStyle::Fill) return strokes(plot, pen, run, stop);
        write(R"(<g fill=")", hexadecimal(pen.colour), "\">\n");
        for (std::size_t i = 0; i < centres.size(); ++i) {
            if (i % kChunk == 0 && (!body_.flush() || stop.stop_requested())) break;
            const Point c = centres[i];
            write(R"(<circle cx=")", c.x, R"(" cy=")", c.y, R"(" r=")", pen.radius);
            if (centres.are_ranked()) write(R"(" data-rank=")", std::to_string(centres.rank(i)));
            write("\"/>\n");
        }
        write("</g>\n");
    }

    /// @param unit  user units per unit of the path data
    void area(std::string_view data, double unit, const Colour& colour) {
        std::string scale;
        append_shortest(scale, unit);
        write(R"(<path fill=")", hexadecimal(colour), R"(" fill-rule="evenodd" transform="scale()", scale, ")\" d=\"",
              data, "\"/>\n");
    }

    void finish() { write("</svg>\n"); }

private:
    /// Writes strokes as paths that are short enough for libxml2, by which many programs read SVG. Programs for
    /// plotters omit strokes of no length, so a touch of the pen is a very short stroke. A closed line in a single path
    /// has the command Z, so that its ends are joined.
    class Strokes {
    public:
        Strokes(DotDocument& document, double touch, bool closed, const std::stop_token& stop)
            : document_(document), touch_(touch), closed_(closed), stop_(stop) {}

        bool should_continue() { return document_.body_.flush() && !stop_.stop_requested(); }

        void begin(Point at) {
            if (points_ == 0) document_.write("<path d=\"");
            document_.write("M", at.x, " ", at.y);
            ++points_;
            is_touch_ = true;
        }

        void line_to(Point at) {
            // A longer line is continued in another path.
            constexpr std::size_t kMaxPoints = 250'000;
            document_.write("L", at.x, " ", at.y);
            is_touch_ = false;
            if (++points_ < kMaxPoints) return;
            closed_ = false;
            close();
            begin(at);
            is_touch_ = false;
        }

        void end() {
            if (is_touch_) {
                document_.write("h", touch_);
            } else if (closed_) {
                document_.write("Z");
            }
            document_.write("\n");
            if (points_ >= kChunk) close();
        }

        void close() {
            if (points_ > 0) document_.write("\"/>\n");
            points_ = 0;
        }

    private:
        DotDocument& document_;
        double touch_;  ///< length of the stroke that stands for a touch of the pen
        bool closed_;   ///< whether the line ends with Z
        const std::stop_token& stop_;
        std::size_t points_ = 0;  ///< number of points in the open path
        bool is_touch_ = false;
    };

    void strokes(const Plot& plot, const Pen& pen, const PenRun& run, const std::stop_token& stop) {
        write(R"(<g fill="none" stroke=")", hexadecimal(pen.colour), R"(" stroke-width=")", pen.width,
              "\" stroke-linecap=\"round\"", plot.style == DotStyle::Stroke ? "" : " stroke-linejoin=\"round\"", ">\n");
        Strokes medium(*this, std::max(pen.radius / 50, elementary::pow(10.0, -decimals_)), plot.closed, stop);
        trace(plot, pen, run, medium);
        medium.close();
        write("</g>\n");
    }

    void append(std::string_view words) { body_.text() += words; }
    void append(double length) { append_rounded(body_.text(), length, decimals_); }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    Body& body_;
    double unit_;
    const Page& page_;
    int decimals_;
};

std::vector<Point> placed(std::span<const Point> points, const PageMapping& position) {
    std::vector<Point> result(points.size());
    std::transform(points.begin(), points.end(), result.begin(), position);
    return result;
}

/// Adds copies of the dots that cross the border of a torus, at the opposite side.
void add_copies(std::vector<Point>& dots, Point size, double radius) {
    for (const bool along_x : {true, false}) {
        const double period = along_x ? size.x : size.y;
        const std::size_t count = dots.size();
        for (std::size_t i = 0; i < count; ++i) {
            const double at = along_x ? dots[i].x : dots[i].y;
            const Point step = along_x ? Point{period, 0} : Point{0, period};
            if (at < radius) dots.push_back(dots[i] + step);
            if (at > period - radius) dots.push_back(dots[i] - step);
        }
    }
}

/// Writes a description of a run of dots, then the dots themselves.
/// @param ranks  ranks of the dots; may be empty
/// @param paper  paper below the dots; null: none
void draw(const Plot& plot, const Pen& pen, const PenRun& run, std::span<const std::uint32_t> ranks,
          const Colour* paper, DotDocument& document, const std::stop_token& stop) {
    const PageMapping position(plot.page, document.unit());
    const PlacedPath dots(run.points, ranks, run.path, position);
    document.describe(run.points.size(), pen.radius, dots.length(), document.unit() * path_length(run.points),
                      plot.page.width_mm ? " mm" : "");
    if (paper != nullptr) document.paper(*paper);
    document.dots(plot, pen, run, dots, stop);
}

/// Path data of SVG whose numbers are integers, and relative to the point before.
class PathData {
public:
    void move_to(Point p) {
        command('m', p);
        is_curve_ = false;
    }
    void line_to(Point p) {
        command('l', p);
        is_curve_ = false;
    }
    /// Leaves the control point out if it is the mirror image of the one before, as in a spline.
    void curve_to(Point control, Point end) {
        constexpr double kNear = 1.5;
        const Point mirrored = at_ + at_ - control_, off = mirrored - control;
        if (is_curve_ && std::abs(off.x) <= kNear && std::abs(off.y) <= kNear) {
            control_ = mirrored;
            command('t', end);
            return;
        }
        const Point from = at_;
        command('q', control);
        control_ = std::exchange(at_, from);
        append(end);
        is_curve_ = true;
    }
    /// Shapes that are only filled need not be closed.
    void close() {}

    std::string take() { return std::move(text_); }

private:
    void command(char name, Point p) {
        text_ += name;
        append(p);
    }
    /// Appends the way to a point.
    void append(Point p) {
        const Point to{std::round(p.x), std::round(p.y)}, way = to - at_;
        const char last = text_.back();
        if (last >= '0' && last <= '9' && way.x >= 0) text_ += ' ';
        text_ += std::to_string(static_cast<long long>(way.x));
        if (way.y >= 0) text_ += ' ';
        text_ += std::to_string(static_cast<long long>(way.y));
        at_ = to;
    }

    std::string text_;
    Point at_{}, control_{};
    bool is_curve_ = false;  ///< whether the last command was a curve, with the control point `control_`
};

/// Returns the blend mode of CSS that mixes inks.
std::string_view blend_of(const Palette& palette) {
    return palette.mixing == Mixing::Add ? "screen" : "multiply";
}

/// Rounds a length to two digits.
double of_two_digits(double length) {
    const double digit = elementary::pow(10, std::floor(elementary::log10(length)) - 1);
    return digit * std::round(length / digit);
}

/// Draws the areas of inks. Each ink with a name is a layer.
void draw_areas(const InkAreas& areas, const Palette& palette, const Page& page, std::size_t sites, Body& body,
                const std::stop_token& stop) {
    // The unit of path data is about this part of the mean spacing of sites.
    constexpr double kPart = 1.0 / 60;
    DotDocument document(page, sites, areas.are_named() ? kLayers : "", body);
    const double pixels = page.box.width() * page.box.height() / static_cast<double>(std::max<std::size_t>(sites, 1));
    const double unit = of_two_digits(kPart * std::sqrt(pixels) * document.unit());
    const PageMapping position(page, document.unit() / unit);
    document.describe(sites);
    const std::vector<std::string> labels = pen_labels(areas.inks);
    document.paper(palette.paper);
    for (std::size_t i = 0; i < areas.inks.size() && !stop.stop_requested(); ++i) {
        PathData data;
        trace_rings(areas.rings[i], page.box, position, data);
        if (areas.are_named()) document.begin_layer(i + 1, labels[i], blend_of(palette));
        document.area(data.take(), unit, areas.inks[i].colour);
        document.marks(areas.inks[i].colour);
        if (areas.are_named()) document.end_layer();
    }
    document.finish();
}

}  // namespace

Canvas canvas_of(const Box& box, double scale) {
    static constexpr double kMaxSide = std::numeric_limits<int>::max();
    const auto side = [scale](double length) {
        return static_cast<int>(std::clamp(std::round(length * scale), 1.0, kMaxSide));
    };
    return {side(box.width()), side(box.height()), scale};
}

bool fits(const Canvas& canvas, std::size_t max_pixels) {
    return static_cast<std::size_t>(canvas.width) <= max_pixels / static_cast<std::size_t>(canvas.height);
}

double fitting_scale(const Box& box, double wished, std::size_t max_pixels) {
    assert(wished > 0 && std::isfinite(wished) && max_pixels >= 1);
    double scale = std::min(wished, std::sqrt(static_cast<double>(max_pixels) / box.width() / box.height()));
    while (!fits(canvas_of(box, scale), max_pixels)) scale *= 0.999;
    return scale;
}

void write_svg(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    const InkAreas* const areas = points.layers.front().areas;
    if (areas != nullptr) return draw_areas(*areas, palette, page, points.size(), body, stop);
    if (points.figure != nullptr) return write_svg_map(points, palette, page, body, stop);
    // Programs for plotters treat each top-level group as a layer, and features are groups.
    const bool layered = points.are_grouped() || points.are_named();
    const bool has_paper = drawing.style == DotStyle::Fill;
    const Plot plot = plot_of(points, page, drawing, path_stop, stop);
    DotDocument document(page, points.size(), layered ? kLayers : "", body);
    if (page.width_mm) {
        body.set_plot(plot.size());
        document.comment(plot.description());
    }
    if (layered && has_paper) document.paper(palette.paper);
    for (std::size_t i = 0; i < points.layers.size(); ++i) {
        const InkDots& layer = points.layers[i];
        const Pen& pen = plot.pens[i];
        const std::string prefix = points.are_named() ? "class-" + std::to_string(i) + "-feature-" : "feature-";
        if (layered) document.begin_layer(i + 1, pen.label, blend_of(palette));
        document.marks(pen.colour);
        std::size_t run = 0;
        points.for_groups(layer, [&](std::uint32_t feature, std::size_t first, std::size_t count) {
            if (stop.stop_requested() || run == pen.runs.size()) return;
            if (points.are_grouped()) document.begin_group(prefix + std::to_string(feature));
            draw(plot, pen, pen.runs[run++], ranks_of(layer.dots, first, count),
                 !layered && has_paper ? &palette.paper : nullptr, document, stop);
            if (points.are_grouped()) document.end_layer();
        });
        if (layered) document.end_layer();
    }
    document.finish();
}

Raster draw_points(std::span<const Point> points, const Page& page, double radius, const std::stop_token& stop) {
    const double scale = page.canvas.scale;
    std::vector<Point> dots = placed(points, PageMapping(page, scale));
    if (page.periodic) add_copies(dots, scale * Point{page.box.width(), page.box.height()}, radius * scale + 1);
    Canvas canvas = page.canvas;
    canvas.scale = 1;
    return draw_dots(dots, canvas, {radius * scale, 0, true}, stop);
}

}  // namespace ccdt::api

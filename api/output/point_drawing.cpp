// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_drawing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "api/output/channel_dots.h"
#include "api/output/ground_curves.h"
#include "api/output/pen_labels.h"
#include "api/output/plot.h"
#include "api/text/numbers.h"
#include "core/tour/short_path.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kChunk = 10'000;  // dots between two checks of the stop token; libxml2 reads paths of up to 10 MB
constexpr std::size_t kTypicalDotBytes = 64;  // typical number of bytes of a dot
constexpr int kDigits = 6;                    // significant digits of a coordinate at the longer side of a page
constexpr int kMaxDecimals = 300;

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

/// Escapes a text for use as the value of an attribute.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                // XML 1.0 cannot represent control characters.
                out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    }
    return out;
}

/// SVG document of dots that is being written.
class DotDocument {
public:
    /// @param attributes  additional attributes of the root element
    DotDocument(const Page& page, std::size_t dots, std::string_view attributes, Body& body)
        : body_(body),
          unit_(page.unit()),
          width_(page.size().x),
          height_(page.size().y),
          decimals_(
              std::min(kDigits - static_cast<int>(std::floor(std::log10(std::max(width_, height_)))), kMaxDecimals)) {
        decimals_ = std::max(decimals_, 0);
        body_.expect(dots * kTypicalDotBytes);
        write(R"(<svg xmlns="http://www.w3.org/2000/svg")", attributes, R"( width=")");
        if (page.width_mm) {
            write(width_, R"(mm" height=")", height_, "mm");
        } else {
            write(std::to_string(page.canvas.width), R"(" height=")", std::to_string(page.canvas.height));
        }
        write(R"(" viewBox="0 0 )", width_, " ", height_, "\">\n");
    }

    /// Returns the number of user units per unit of the points.
    double unit() const { return unit_; }

    void describe(std::size_t dots, double radius, double path, double original, std::string_view unit) {
        write("<desc>", std::to_string(dots), " dots along a path of ", path, unit, "; in their original order it is ",
              original, unit, "; their radius is ", radius, unit, "</desc>\n");
    }

    void paper(const Colour& colour) {
        if (colour.transparent) return;
        write(R"(<rect width=")", width_, R"(" height=")", height_, R"(" fill=")", hexadecimal(colour), "\"/>\n");
    }

    /// Begins a layer of the drawing. Programs that change pens between layers read the layer's number in its id.
    /// @param number  from 1, in drawing order
    /// @param blend   blend mode of CSS; empty: the layer hides the layers below it
    /// @param clip    id of the path to which the layer is clipped; empty: none
    void begin_layer(std::size_t number, std::string_view label, std::string_view blend, std::string_view clip = {}) {
        write(R"(<g id="layer)", std::to_string(number), R"(" inkscape:groupmode="layer" inkscape:label=")",
              escaped(label), "\"");
        if (!blend.empty()) write(R"( style="mix-blend-mode:)", blend, "\"");
        if (!clip.empty()) write(R"( clip-path="url(#)", clip, ")\"");
        write(">\n");
    }

    void begin_group(std::string_view id) { write(R"(<g id=")", id, "\">\n"); }

    /// Begins a group that is clipped to a clip path.
    void begin_clip(std::string_view id) { write(R"(<g clip-path="url(#)", id, ")\">\n"); }

    void end_group() { write("</g>\n"); }

    void end_layer() { write("</g>\n"); }

    /// Draws discs of equal size, or the strokes of a pen.
    void dots(const Plot& plot, const Pen& pen, const PenRun& run, const PlacedPath& centres,
              const std::stop_token& stop) {
        if (plot.style != DotStyle::Fill) return strokes(plot, pen, run, stop);
        discs(
            centres, [&](std::size_t) { return pen.radius; }, pen.colour, stop);
    }

    void define_clip(std::string_view id, std::string_view data) {
        write(R"(<clipPath id=")", id, R"("><path clip-rule="evenodd" d=")", data, "\"/></clipPath>\n");
    }

    /// @param radius_of  returns the radius of a dot, by its index in the path
    template <class RadiusOf>
    void discs(const PlacedPath& centres, const RadiusOf& radius_of, const Colour& colour,
               const std::stop_token& stop) {
        write(R"(<g fill=")", hexadecimal(colour), "\">\n");
        for_chunks(centres, stop, [&](std::size_t first, std::size_t end) {
            for (std::size_t i = first; i < end; ++i) {
                const Point c = centres[i];
                write(R"(<circle cx=")", c.x, R"(" cy=")", c.y, R"(" r=")", radius_of(i));
                if (centres.are_ranked()) write(R"(" data-rank=")", std::to_string(centres.rank(i)));
                write("\"/>\n");
            }
        });
        write("</g>\n");
    }

    /// @param blend  blend mode of CSS; empty: the area hides what is below it
    void area(std::string_view data, const Colour& colour, std::string_view blend = {}) {
        write(R"(<path fill=")", hexadecimal(colour), R"(" fill-rule="evenodd")");
        if (!blend.empty()) write(R"( style="mix-blend-mode:)", blend, "\"");
        write(R"( d=")", data, "\"/>\n");
    }

    int decimals() const { return decimals_; }

    void finish() { write("</svg>\n"); }

private:
    /// Writes strokes as paths that are short enough for libxml2, by which many programs read SVG. Programs for
    /// plotters omit strokes of no length, so a touch of the pen is a very short stroke.
    class Strokes {
    public:
        Strokes(DotDocument& document, double touch, const std::stop_token& stop)
            : document_(document), touch_(touch), stop_(stop) {}

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
            close();
            begin(at);
            is_touch_ = false;
        }

        void end() {
            if (is_touch_) document_.write("h", touch_);
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
        const std::stop_token& stop_;
        std::size_t points_ = 0;  ///< number of points in the open path
        bool is_touch_ = false;
    };

    void strokes(const Plot& plot, const Pen& pen, const PenRun& run, const std::stop_token& stop) {
        write(R"(<g fill="none" stroke=")", hexadecimal(pen.colour), R"(" stroke-width=")", pen.width,
              "\" stroke-linecap=\"round\"", plot.style == DotStyle::Stroke ? "" : " stroke-linejoin=\"round\"", ">\n");
        Strokes medium(*this, std::max(pen.radius / 50, std::pow(10, -decimals_)), stop);
        trace(plot, pen, run, medium);
        medium.close();
        write("</g>\n");
    }

    /// Calls function(first, end) for ranges of kChunk dots. Ends early on a stop, or if the sink of the body fails.
    template <class Function>
    void for_chunks(const PlacedPath& centres, const std::stop_token& stop, Function&& function) {
        for (std::size_t i = 0; i < centres.size() && body_.flush() && !stop.stop_requested(); i += kChunk)
            function(i, std::min(i + kChunk, centres.size()));
    }

    void append(std::string_view words) { body_.text() += words; }
    void append(double length) { append_rounded(body_.text(), length, decimals_); }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    Body& body_;
    double unit_;
    double width_;
    double height_;
    int decimals_;
};

std::vector<Point> placed(std::span<const Point> points, const PageMapping& place) {
    std::vector<Point> result(points.size());
    std::transform(points.begin(), points.end(), result.begin(), place);
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
    const PageMapping place(plot.page, document.unit());
    const PlacedPath dots(run.points, ranks, run.path, place);
    document.describe(run.points.size(), pen.radius, dots.length(), document.unit() * path_length(run.points),
                      plot.page.width_mm ? " mm" : "");
    if (paper != nullptr) document.paper(*paper);
    document.dots(plot, pen, run, dots, stop);
}

/// Converts the rings around black ground to path data of SVG.
std::string curves(std::span<const std::vector<Point>> rings, const Page& page, int decimals) {
    std::string data;
    const auto append = [&](std::string_view command, Point p) {
        data += command;
        append_rounded(data, p.x, decimals);
        data += ' ';
        append_rounded(data, p.y, decimals);
    };
    struct Data {
        const decltype(append)& add;
        std::string& text;
        void move_to(Point p) { add("M", p); }
        void line_to(Point p) { add("L", p); }
        void curve_to(Point control, Point end) {
            add("Q", control);
            add(" ", end);
        }
        void close() { text += "Z\n"; }
    } writer{append, data};
    trace_ground(rings, page, writer);
    return data;
}

/// Orders some of the points along a short path.
/// @param numbers  indices of these points
std::vector<std::uint32_t> path_through(std::span<const std::uint32_t> numbers, std::span<const Point> points,
                                        const std::stop_token& path_stop) {
    std::vector<Point> own;
    for (const std::uint32_t i : numbers) own.push_back(points[i]);
    std::vector<std::uint32_t> path;
    for (const std::uint32_t i : short_path(own, path_stop)) path.push_back(numbers[i]);
    return path;
}

/// Returns the name of an ink for use in ids. A number sign is replaced, since links to ids cannot contain it.
std::string id_of(const Ink& ink) {
    return ink.name.starts_with('#') ? "ink-" + ink.name.substr(1) : ink.name;
}

/// Returns the blend mode of CSS that mixes inks.
std::string_view blend_of(const Palette& palette) {
    return palette.mixing == Mixing::Add ? "screen" : "multiply";
}

/// Draws dots on both sides of the tonal scale. Each channel has three layers, from bottom to top: ink dots, black
/// ground, paper dots. A dot on the boundary of the ground is both an ink dot and a paper dot. The black ground hides
/// ink dots, and paper dots are clipped to the black ground. Thus each part of a dot has the colour opposite to its
/// ground.
void draw_two_sides(const PointSet& kinds, const Palette& palette, const Page& page, Body& body,
                    const std::stop_token& path_stop, const std::stop_token& stop) {
    const Grounds& grounds = kinds.layers.front().two_sides->grounds;
    const bool layered = kinds.are_named();
    const Colour bare = paper_dot_colour(kinds, palette);
    std::vector<ChannelDots> channels;
    for (std::size_t c = 0; c < grounds.inks.size(); ++c) {
        ChannelDots& dots = channels.emplace_back(dots_of_channel(kinds, c));
        dots.ink = path_through(dots.ink, dots.points, path_stop);
        dots.paper = path_through(dots.paper, dots.points, path_stop);
    }
    DotDocument document(page, kinds.size(), kLayers, body);
    const PageMapping place(page, document.unit());
    const std::vector<std::string> labels = pen_labels(grounds.inks);
    // Top-level layers get the first numbers, because some programs number only top-level layers.
    std::size_t number = layered ? channels.size() : 0;
    document.paper(palette.paper);
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const ChannelDots& dots = channels[c];
        const Ink& ink = grounds.inks[c];
        const std::string black = layered ? id_of(ink) + "-black" : "black";
        const std::string ground = curves(grounds.rings[c], page, document.decimals());
        const auto draw_side = [&](const std::vector<std::uint32_t>& path, const Colour& colour) {
            const PlacedPath centres(dots.points, {}, path, place);
            const auto radius_of = [&](std::size_t i) {
                return document.unit() * static_cast<double>(dots.radii[path[i]]);
            };
            document.discs(centres, radius_of, colour, stop);
        };
        if (layered) document.begin_layer(c + 1, labels[c], blend_of(palette));
        document.define_clip(black, ground);
        document.begin_layer(++number, "ink dots", "");
        draw_side(dots.ink, ink.colour);
        document.end_layer();
        document.begin_layer(++number, "ground", "");
        document.area(ground, ink.colour);
        document.end_layer();
        document.begin_layer(++number, "paper dots", "", black);
        draw_side(dots.paper, bare);
        document.end_layer();
        if (layered) document.end_layer();
    }
    document.finish();
}

/// Draws dots on both sides of the tonal scale. The ground is a layer, and the dots of each kind are a layer. A dot has
/// the colour of the inks of its ground, after the inks of its kind have been flipped. A dot that the boundary of a
/// ground crosses is drawn once for each combination of grounds under it, clipped to these grounds.
class KindLayers {
public:
    KindLayers(const PointSet& kinds, const Palette& palette, const Page& page, Body& body,
               const std::stop_token& path_stop, const std::stop_token& stop)
        : kinds_(kinds.layers),
          labels_(pen_labels(kinds.inks())),
          palette_(palette),
          grounds_(kinds_.front().two_sides->grounds),
          document_(page, kinds.size(), kLayers, body),
          place_(page, document_.unit()),
          path_stop_(path_stop),
          stop_(stop) {
        for (const auto& rings : grounds_.rings) curves_.push_back(curves(rings, page, document_.decimals()));
        const auto& [min, max] = page.box;
        const std::vector<std::vector<Point>> border = {{min, {max.x, min.y}, max, {min.x, max.y}}};
        border_ = curves(border, page, document_.decimals());
    }

    void draw() {
        document_.paper(palette_.paper);
        for (std::size_t c = 0; c < curves_.size(); ++c) {
            document_.define_clip(clip_of(c, true), curves_[c]);
            document_.define_clip(clip_of(c, false), border_ + curves_[c]);
        }
        document_.begin_layer(1, "ground", "");
        for (std::size_t c = 0; c < curves_.size(); ++c)
            document_.area(curves_[c], grounds_.inks[c].colour, blend_of(palette_));
        document_.end_layer();
        for (std::size_t k = 0; k < kinds_.size(); ++k) {
            document_.begin_layer(k + 2, labels_[k], "");
            draw(kinds_[k]);
            document_.end_layer();
        }
        document_.finish();
    }

private:
    /// Indices of dots, grouped by two sets of bits: the inks of the ground on which the dots are drawn, and
    /// the channels to whose ground the dots are clipped.
    using Groups = std::map<std::pair<unsigned, unsigned>, std::vector<std::uint32_t>>;

    static std::string clip_of(std::size_t channel, bool is_black) {
        return std::string(is_black ? "ink" : "bare") + "-" + std::to_string(channel + 1);
    }

    void draw(const InkDots& kind) {
        for (const auto& [key, numbers] : groups_of(*kind.two_sides, kind.dots.points.size())) {
            const auto [ground, cut] = key;
            for_channels(
                cut, [&, ground = ground](std::size_t c) { document_.begin_clip(clip_of(c, (ground >> c & 1) != 0)); });
            const std::vector<std::uint32_t> path = path_through(numbers, kind.dots.points, path_stop_);
            const auto radius_of = [&](std::size_t i) {
                return document_.unit() * static_cast<double>(kind.two_sides->dots.radii[path[i]]);
            };
            document_.discs(PlacedPath(kind.dots.points, {}, path, place_), radius_of,
                            colour_of(ground ^ kind.two_sides->flips), stop_);
            for_channels(cut, [&](std::size_t) { document_.end_group(); });
        }
    }

    Groups groups_of(const TwoSidedDots& dots, std::size_t count) const {
        const unsigned all = (1U << grounds_.inks.size()) - 1;
        Groups groups;
        for (std::uint32_t i = 0; i < count; ++i) {
            const unsigned cut = dots.dots.cut[i], ground = ~dots.dots.white[i] & all;
            // Visits all subsets of the channels that are cut.
            for (unsigned flipped = cut;; flipped = (flipped - 1) & cut) {
                groups[{ground ^ flipped, cut}].push_back(i);
                if (flipped == 0) break;
            }
        }
        return groups;
    }

    /// Returns the colour of a set of inks, mixed in the same way as the areas of the ground.
    Colour colour_of(unsigned inks) const {
        Colour mixed = palette_.paper;
        for_channels(inks, [&](std::size_t c) {
            const Colour& ink = grounds_.inks[c].colour;
            const auto mix = [&](unsigned char below, unsigned char above) {
                const bool adds = palette_.mixing == Mixing::Add;
                const int a = adds ? 255 - below : below, b = adds ? 255 - above : above;
                const int product = (a * b + 127) / 255;
                return static_cast<unsigned char>(adds ? 255 - product : product);
            };
            mixed = {mix(mixed.red, ink.red), mix(mixed.green, ink.green), mix(mixed.blue, ink.blue)};
        });
        return mixed;
    }

    std::span<const InkDots> kinds_;
    std::vector<std::string> labels_;
    const Palette& palette_;
    const Grounds& grounds_;
    DotDocument document_;
    PageMapping place_;
    std::stop_token path_stop_, stop_;
    std::vector<std::string> curves_;  ///< [channels] path data of black ground
    std::string border_;               ///< path data of the border of the page
};

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
    if (points.layers.front().two_sides != nullptr) {
        if (drawing.layers == Layers::Kind && points.are_named())
            return KindLayers(points, palette, page, body, path_stop, stop).draw();
        return draw_two_sides(points, palette, page, body, path_stop, stop);
    }
    // Programs for plotters treat each top-level group as a layer, and features are groups.
    const bool layered = points.are_grouped() || points.are_named();
    const bool has_paper = drawing.style == DotStyle::Fill;
    const Plot plot = plot_of(points, page, drawing, path_stop, stop);
    if (page.width_mm) body.set_plot_seconds(plot.seconds());
    DotDocument document(page, points.size(), layered ? kLayers : "", body);
    if (layered && has_paper) document.paper(palette.paper);
    for (std::size_t i = 0; i < points.layers.size(); ++i) {
        const InkDots& layer = points.layers[i];
        const Pen& pen = plot.pens[i];
        const std::string prefix = points.are_named() ? "class-" + std::to_string(i) + "-feature-" : "feature-";
        if (layered) document.begin_layer(i + 1, pen.label, blend_of(palette));
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

#include "api/output/point_drawing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "api/text/numbers.h"
#include "core/tour/short_path.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kChunk = 10'000;  // dots between two looks at the stop token; libxml2 reads paths of up to 10 MB
constexpr std::size_t kUsualDot = 64;   // bytes
constexpr int kDigits = 6;              // of a page's longer side
constexpr int kMostDecimals = 300;

/// Attributes of a drawing with layers. Isolated, they do not mix with the page that the drawing stands on.
constexpr std::string_view kLayers =
    R"( xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" style="isolation:isolate")";

/// Mapping of points to the page, from its upper left corner, in units of it.
class Placing {
public:
    Placing(const Page& page, double unit) : page_(page), unit_(unit) {}

    Point operator()(Point p) const {
        const Box& box = page_.box;
        return {(p.x - box.min.x) * unit_, (page_.y_up ? box.max.y - p.y : p.y - box.min.y) * unit_};
    }

private:
    const Page& page_;
    double unit_;
};

/// SVG document of dots in the making.
class DotDocument {
public:
    /// @param attributes  of the root, besides what it always has
    DotDocument(const Page& page, std::size_t dots, std::string_view attributes)
        : unit_(page.width_mm ? *page.width_mm / page.box.width() : 1),
          width_(page.box.width() * unit_),
          height_(page.box.height() * unit_),
          decimals_(
              std::min(kDigits - static_cast<int>(std::floor(std::log10(std::max(width_, height_)))), kMostDecimals)) {
        decimals_ = std::max(decimals_, 0);
        out_.reserve(dots * kUsualDot);
        write(R"(<svg xmlns="http://www.w3.org/2000/svg")", attributes, R"( width=")");
        if (page.width_mm) {
            write(width_, R"(mm" height=")", height_, "mm");
        } else {
            write(std::to_string(page.canvas.width), R"(" height=")", std::to_string(page.canvas.height));
        }
        write(R"(" viewBox="0 0 )", width_, " ", height_, "\">\n");
    }

    /// Gives user units per unit of the points.
    double unit() const { return unit_; }

    void describe(std::size_t dots, double radius, double path, double original, std::string_view unit) {
        write("<desc>", std::to_string(dots), " dots along a path of ", path, unit, "; in their original order it is ",
              original, unit, "; their radius is ", radius, unit, "</desc>\n");
    }

    void paper(const Colour& colour) {
        if (colour.transparent) return;
        write(R"(<rect width=")", width_, R"(" height=")", height_, R"(" fill=")", hexadecimal(colour), "\"/>\n");
    }

    /// @param blend  of CSS
    void begin_layer(std::string_view name, std::string_view blend) {
        write(R"(<g inkscape:groupmode="layer" inkscape:label=")", name, R"(" style="mix-blend-mode:)", blend, "\">\n");
    }

    void begin_group(std::string_view id) { write(R"(<g id=")", id, "\">\n"); }

    void end_layer() { write("</g>\n"); }

    void dots(std::span<const Point> centres, double radius, DotStyle style, const Colour& colour,
              const std::stop_token& stop) {
        if (style == DotStyle::Stroke) return strokes(centres, radius, colour, stop);
        discs(centres, radius, colour, stop);
    }

    std::string finish() {
        write("</svg>\n");
        return std::move(out_);
    }

private:
    void discs(std::span<const Point> centres, double radius, const Colour& colour, const std::stop_token& stop) {
        write(R"(<g fill=")", hexadecimal(colour), "\">\n");
        for (std::size_t i = 0; i < centres.size() && !stop.stop_requested(); i += kChunk) {
            for (const Point& c : chunk(centres, i)) {
                write(R"(<circle cx=")", c.x, R"(" cy=")", c.y, R"(" r=")", radius, "\"/>\n");
            }
        }
        write("</g>\n");
    }

    /// Draws strokes of some length: programs for plotters leave out those of none.
    void strokes(std::span<const Point> centres, double radius, const Colour& colour, const std::stop_token& stop) {
        const double length = std::max(radius / 50, std::pow(10, -decimals_));
        write(R"(<g fill="none" stroke=")", hexadecimal(colour), R"(" stroke-width=")", 2 * radius,
              "\" stroke-linecap=\"round\">\n");
        for (std::size_t i = 0; i < centres.size() && !stop.stop_requested(); i += kChunk) {
            write("<path d=\"");
            for (const Point& c : chunk(centres, i)) write("M", c.x, " ", c.y, "h", length, "\n");
            write("\"/>\n");
        }
        write("</g>\n");
    }

    static std::span<const Point> chunk(std::span<const Point> all, std::size_t first) {
        return all.subspan(first, std::min(kChunk, all.size() - first));
    }

    void append(std::string_view words) { out_ += words; }
    void append(double length) { append_rounded(out_, length, decimals_); }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    double unit_;
    double width_;
    double height_;
    int decimals_;
    std::string out_;
};

std::vector<Point> placed(std::span<const Point> points, const Placing& place) {
    std::vector<Point> result(points.size());
    std::transform(points.begin(), points.end(), result.begin(), place);
    return result;
}

/// Writes a text as the value of an attribute.
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
                // Characters that XML 1.0 has no way to write.
                out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    }
    return out;
}

/// Adds the copies of dots that reach in from beyond the border of a torus.
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

/// Orders dots along a short path, as they lie on the page, and has the document tell of it.
std::vector<Point> order(std::span<const Point> points, double radius, const Page& page, DotDocument& document,
                         const std::stop_token& hurry) {
    const Placing place(page, document.unit());
    std::vector<Point> dots;
    dots.reserve(points.size());
    for (const std::uint32_t i : short_path(points, hurry)) dots.push_back(place(points[i]));
    document.describe(points.size(), document.unit() * radius, path_length(dots), document.unit() * path_length(points),
                      page.width_mm ? " mm" : "");
    return dots;
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

std::string write_svg(std::span<const InkDots> inks, const Palette& palette, const Page& page, DotStyle style,
                      const std::stop_token& hurry, const std::stop_token& stop) {
    const bool layered = are_named(inks);
    const bool has_paper = style == DotStyle::Fill;
    DotDocument document(page, count_points(inks), layered ? kLayers : "");
    if (layered && has_paper) document.paper(palette.paper);
    for (const auto& [ink, distribution, radius] : inks) {
        if (layered) document.begin_layer(ink.name, palette.mixing == Mixing::Add ? "screen" : "multiply");
        const std::vector<Point> dots = order(distribution.points, radius, page, document, hurry);
        if (!layered && has_paper) document.paper(palette.paper);
        document.dots(dots, radius * document.unit(), style, ink.colour, stop);
        if (layered) document.end_layer();
    }
    return document.finish();
}

std::string write_map_svg(const MapOfDots& map, const Palette& palette, const Page& page, DotStyle style,
                          const std::stop_token& hurry, const std::stop_token& stop) {
    const bool layered = map.are_named();
    DotDocument document(page, map.size(), layered ? kLayers : "");
    if (style == DotStyle::Fill) document.paper(palette.paper);
    std::size_t number = 0;
    for (const auto& [ink, dots, radius] : map.classes) {
        if (layered) document.begin_layer(escaped(ink.name), "multiply");
        const std::string prefix = layered ? "class-" + std::to_string(number++) + "-feature-" : "feature-";
        for_features(dots, [&, &ink = ink, &radius = radius, &points = dots.dots.points](
                               std::uint32_t feature, std::size_t first, std::size_t count) {
            if (stop.stop_requested()) return;
            document.begin_group(prefix + std::to_string(feature));
            const auto path = order(std::span(points).subspan(first, count), radius, page, document, hurry);
            document.dots(path, radius * document.unit(), style, ink.colour, stop);
            document.end_layer();
        });
        if (layered) document.end_layer();
    }
    return document.finish();
}

Raster draw_points(std::span<const Point> points, const Page& page, double radius, const std::stop_token& stop) {
    const double scale = page.canvas.scale;
    std::vector<Point> dots = placed(points, Placing(page, scale));
    if (page.periodic) add_copies(dots, scale * Point{page.box.width(), page.box.height()}, radius * scale + 1);
    Canvas canvas = page.canvas;
    canvas.scale = 1;
    return draw_dots(dots, canvas, {radius * scale, 0, true}, stop);
}

}  // namespace ccdt::api

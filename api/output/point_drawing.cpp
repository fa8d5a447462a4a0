#include "api/output/point_drawing.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
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

/// Points in the order of a path, as they lie on the page.
class PlacedPath {
public:
    /// What is referred to must outlive it.
    /// @param ranks  of the points, or none
    PlacedPath(std::span<const Point> points, std::span<const std::uint32_t> ranks, std::span<const std::uint32_t> path,
               const Placing& placing)
        : points_(points), ranks_(ranks), path_(path), placing_(placing) {}

    std::size_t size() const { return path_.size(); }
    Point operator[](std::size_t i) const { return placing_(points_[path_[i]]); }

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
    const Placing& placing_;
};

/// SVG document of dots in the making.
class DotDocument {
public:
    /// @param attributes  of the root, besides what it always has
    DotDocument(const Page& page, std::size_t dots, std::string_view attributes, Body& body)
        : body_(body),
          unit_(page.width_mm ? *page.width_mm / page.box.width() : 1),
          width_(page.box.width() * unit_),
          height_(page.box.height() * unit_),
          decimals_(
              std::min(kDigits - static_cast<int>(std::floor(std::log10(std::max(width_, height_)))), kMostDecimals)) {
        decimals_ = std::max(decimals_, 0);
        body_.expect(dots * kUsualDot);
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

    void dots(const PlacedPath& centres, double radius, DotStyle style, const Colour& colour,
              const std::stop_token& stop) {
        if (style == DotStyle::Stroke) return strokes(centres, radius, colour, stop);
        discs(centres, radius, colour, stop);
    }

    /// Begins a layer that is not mixed with those below it.
    /// @param clip  id of the path outside of which nothing is seen; empty: none
    void begin_plain_layer(std::string_view id, std::string_view label, std::string_view clip) {
        write(R"(<g id=")", id, R"(" inkscape:groupmode="layer" inkscape:label=")", label, "\"");
        if (!clip.empty()) write(R"( clip-path="url(#)", clip, ")\"");
        write(">\n");
    }

    /// Defines a clip path.
    void define_clip(std::string_view id, std::string_view data) {
        write(R"(<clipPath id=")", id, R"("><path clip-rule="evenodd" d=")", data, "\"/></clipPath>\n");
    }

    /// @param radius_of  the radius of each dot of the path
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

    void area(std::string_view data, const Colour& colour) {
        write(R"(<path fill=")", hexadecimal(colour), R"(" fill-rule="evenodd" d=")", data, "\"/>\n");
    }

    int decimals() const { return decimals_; }

    void finish() { write("</svg>\n"); }

private:
    void discs(const PlacedPath& centres, double radius, const Colour& colour, const std::stop_token& stop) {
        discs(
            centres, [radius](std::size_t) { return radius; }, colour, stop);
    }

    /// Draws strokes of some length: programs for plotters leave out those of none.
    void strokes(const PlacedPath& centres, double radius, const Colour& colour, const std::stop_token& stop) {
        const double length = std::max(radius / 50, std::pow(10, -decimals_));
        write(R"(<g fill="none" stroke=")", hexadecimal(colour), R"(" stroke-width=")", 2 * radius,
              "\" stroke-linecap=\"round\">\n");
        for_chunks(centres, stop, [&](std::size_t first, std::size_t end) {
            write("<path d=\"");
            for (std::size_t i = first; i < end; ++i) write("M", centres[i].x, " ", centres[i].y, "h", length, "\n");
            write("\"/>\n");
        });
        write("</g>\n");
    }

    /// Calls function(first, end) for each so many dots, until it is stopped or nobody takes them.
    template <class Function>
    void for_chunks(const PlacedPath& centres, const std::stop_token& stop, Function&& function) {
        for (std::size_t i = 0; i < centres.size() && body_.hand_on() && !stop.stop_requested(); i += kChunk)
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

/// Orders dots as a page has them.
std::vector<std::uint32_t> path_of(std::span<const Point> points, const Page& page, const std::stop_token& hurry) {
    if (page.along_path) return short_path(points, hurry);
    std::vector<std::uint32_t> path(points.size());
    std::iota(path.begin(), path.end(), 0U);
    return path;
}

/// Draws dots along a path, and has the document tell of it before.
/// @param ranks  of the dots, or none
/// @param paper  that lies below them, if any
void draw(std::span<const Point> points, std::span<const std::uint32_t> ranks, std::span<const std::uint32_t> path,
          double radius, const Colour& colour, const Page& page, DotStyle style, const Colour* paper,
          DotDocument& document, const std::stop_token& stop) {
    const Placing place(page, document.unit());
    const PlacedPath dots(points, ranks, path, place);
    document.describe(points.size(), document.unit() * radius, dots.length(), document.unit() * path_length(points),
                      page.width_mm ? " mm" : "");
    if (paper != nullptr) document.paper(*paper);
    document.dots(dots, radius * document.unit(), style, colour, stop);
}

/// Writes rings as closed curves: quadratic splines with the rings' points as controls, but straight along the border
/// of the page.
std::string curves(std::span<const std::vector<Point>> rings, const Page& page, const Placing& place, int decimals) {
    std::string data;
    const auto append = [&](std::string_view command, Point p) {
        data += command;
        append_rounded(data, p.x, decimals);
        data += ' ';
        append_rounded(data, p.y, decimals);
    };
    const auto is_on_border = [&](Point p) {
        return p.x <= page.box.min.x || p.y <= page.box.min.y || p.x >= page.box.max.x || p.y >= page.box.max.y;
    };
    for (const std::vector<Point>& ring : rings) {
        const auto middle = [&](std::size_t i) { return place(0.5 * (ring[i] + ring[(i + 1) % ring.size()])); };
        append("M", middle(ring.size() - 1));
        for (std::size_t i = 0; i < ring.size(); ++i) {
            append(is_on_border(ring[i]) ? "L" : "Q", place(ring[i]));
            append(is_on_border(ring[i]) ? "L" : " ", middle(i));
        }
        data += "Z\n";
    }
    return data;
}

/// Name of an ink as a part of ids: links to these cannot have a number sign.
std::string id_of(const Ink& ink) {
    return ink.name.starts_with('#') ? "ink-" + ink.name.substr(1) : ink.name;
}

/// Dots of all kinds that flip a channel.
struct ChannelDots {
    std::vector<Point> points;
    std::vector<float> radii;
    std::vector<std::vector<std::uint32_t>> paths;  ///< of ink dots, and of paper dots; those that are cut are in both
};

ChannelDots dots_of_channel(std::span<const InkDots> kinds, std::size_t channel, const Page& page,
                            const std::stop_token& hurry) {
    ChannelDots all;
    std::vector<bool> white, cut;
    for (const InkDots& kind : kinds) {
        const auto& [dots, flips, grounds] = *kind.two_sides;
        if ((flips >> channel & 1) == 0) continue;
        all.points.insert(all.points.end(), kind.dots.points.begin(), kind.dots.points.end());
        all.radii.insert(all.radii.end(), dots.radii.begin(), dots.radii.end());
        for (const std::uint8_t bits : dots.white) white.push_back((bits >> channel & 1) != 0);
        for (const std::uint8_t bits : dots.cut) cut.push_back((bits >> channel & 1) != 0);
    }
    for (const bool of_ink : {true, false}) {
        std::vector<std::uint32_t> numbers;
        std::vector<Point> own;
        for (std::uint32_t i = 0; i < all.points.size(); ++i) {
            if (white[i] != of_ink && !cut[i]) continue;
            numbers.push_back(i);
            own.push_back(all.points[i]);
        }
        all.paths.emplace_back();
        for (const std::uint32_t i : path_of(own, page, hurry)) all.paths.back().push_back(numbers[i]);
    }
    return all;
}

/// Draws dots on both sides of the tonal scale, of each channel as three layers: ink dots, ink ground on them, paper
/// dots on that. Dots that the boundary of the ground cuts are in the first and in the last; the ground covers those in
/// the first, and those in the last are clipped by it, so that each part has the colour opposite to its ground.
void draw_two_sides(std::span<const InkDots> kinds, const Palette& palette, const Page& page, Body& body,
                    const std::stop_token& hurry, const std::stop_token& stop) {
    const Grounds& grounds = kinds.front().two_sides->grounds;
    const bool layered = are_named(kinds), adds = palette.mixing == Mixing::Add;
    std::vector<ChannelDots> channels;
    for (std::size_t c = 0; c < grounds.inks.size(); ++c) channels.push_back(dots_of_channel(kinds, c, page, hurry));
    DotDocument document(page, count_points(kinds), kLayers, body);
    const Placing place(page, document.unit());
    document.paper(palette.paper);
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const ChannelDots& dots = channels[c];
        const Ink& ink = grounds.inks[c];
        const Colour& bare = !layered ? palette.paper : adds ? kBlack : kWhite;
        const std::string id = layered ? id_of(ink) + "-" : "", black = id + "black";
        const std::string ground = curves(grounds.rings[c], page, place, document.decimals());
        const auto draw_side = [&](const std::vector<std::uint32_t>& path, const Colour& colour) {
            const PlacedPath centres(dots.points, {}, path, place);
            const auto radius_of = [&](std::size_t i) {
                return document.unit() * static_cast<double>(dots.radii[path[i]]);
            };
            document.discs(centres, radius_of, colour, stop);
        };
        if (layered) document.begin_layer(ink.name, adds ? "screen" : "multiply");
        document.define_clip(black, ground);
        document.begin_plain_layer(id + "ink", "ink dots", "");
        draw_side(dots.paths[0], ink.colour);
        document.end_layer();
        document.begin_plain_layer(id + "ground", "ground", "");
        document.area(ground, ink.colour);
        document.end_layer();
        document.begin_plain_layer(id + "paper", "paper dots", black);
        draw_side(dots.paths[1], bare);
        document.end_layer();
        if (layered) document.end_layer();
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

void write_svg(std::span<const InkDots> inks, const Palette& palette, const Page& page, DotStyle style, Body& body,
               const std::stop_token& hurry, const std::stop_token& stop) {
    if (inks.front().two_sides != nullptr) return draw_two_sides(inks, palette, page, body, hurry, stop);
    const bool layered = are_named(inks);
    const bool has_paper = style == DotStyle::Fill;
    std::vector<std::vector<std::uint32_t>> paths;
    for (const InkDots& each : inks) paths.push_back(path_of(each.dots.points, page, hurry));
    DotDocument document(page, count_points(inks), layered ? kLayers : "", body);
    if (layered && has_paper) document.paper(palette.paper);
    for (std::size_t i = 0; i < inks.size(); ++i) {
        const auto& [ink, distribution, radius, two_sides] = inks[i];
        if (layered) document.begin_layer(ink.name, palette.mixing == Mixing::Add ? "screen" : "multiply");
        draw(distribution.points, distribution.ranks, paths[i], radius, ink.colour, page, style,
             !layered && has_paper ? &palette.paper : nullptr, document, stop);
        if (layered) document.end_layer();
    }
    document.finish();
}

void write_map_svg(const MapOfDots& map, const Palette& palette, const Page& page, DotStyle style, Body& body,
                   const std::stop_token& hurry, const std::stop_token& stop) {
    const bool layered = map.are_named();
    std::vector<std::vector<std::uint32_t>> paths;  // of all groups
    for (const MapDots& each : map.classes) {
        for_features(each.dots, [&](std::uint32_t, std::size_t first, std::size_t count) {
            if (stop.stop_requested()) return;
            paths.push_back(path_of(std::span(each.dots.dots.points).subspan(first, count), page, hurry));
        });
    }
    DotDocument document(page, map.size(), layered ? kLayers : "", body);
    if (style == DotStyle::Fill) document.paper(palette.paper);
    std::size_t number = 0, group = 0;
    for (const auto& [ink, dots, radius] : map.classes) {
        if (layered) document.begin_layer(escaped(ink.name), "multiply");
        const std::string prefix = layered ? "class-" + std::to_string(number++) + "-feature-" : "feature-";
        for_features(dots, [&, &ink = ink, &radius = radius, &all = dots.dots](std::uint32_t feature, std::size_t first,
                                                                               std::size_t count) {
            if (stop.stop_requested() || group == paths.size()) return;
            document.begin_group(prefix + std::to_string(feature));
            draw(std::span(all.points).subspan(first, count), ranks_of(all, first, count), paths[group++], radius,
                 ink.colour, page, style, nullptr, document, stop);
            document.end_layer();
        });
        if (layered) document.end_layer();
    }
    document.finish();
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

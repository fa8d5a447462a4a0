// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_map.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/output/map_figure.h"
#include "api/output/svg_page.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

/// The medium of draw_map() for SVG.
class SvgMap {
public:
    SvgMap(const Page& page, Body& body) : body_(body), decimals_(svg_decimals(page)) {}

    bool should_continue() const { return body_.flush(); }

    /// Begins the document: the colours of the classes, and the paper.
    void begin(const PointSet& points, const Palette& palette, const Page& page) {
        constexpr std::size_t kTypicalDotBytes = 72;
        body_.expect(points.size() * kTypicalDotBytes);
        begin_svg(page, "", body_);
        write("<style>");
        for (std::size_t i = 0; i < points.layers.size(); ++i)
            write(".class-", std::to_string(i), "{fill:", hexadecimal(points.layers[i].ink.colour), "}");
        write("</style>\n<desc>", std::to_string(points.size()), " dots of a map</desc>\n");
        if (palette.paper.transparent) return;
        const Box area = page.drawing();
        write(R"(<rect x=")", area.min.x, R"(" y=")", area.min.y, R"(" width=")", area.width(), R"(" height=")",
              area.height(), R"(" fill=")", hexadecimal(palette.paper), "\"/>\n");
    }

    /// Lines become paths that are short enough for libxml2.
    void begin_line(Point at) {
        constexpr std::size_t kMaxCorners = 10'000;
        if (corners_ > kMaxCorners) end_path();
        write(corners_ == 0 ? "<path d=\"M" : "M", at.x, " ", at.y);
        ++corners_;
        body_.flush();
    }
    void line_to(Point at) {
        write("L", at.x, " ", at.y);
        ++corners_;
    }
    void end_path() {
        if (corners_ > 0) write("\"/>\n");
        corners_ = 0;
    }
    void begin_lines(const Colour& colour, double width) {
        write(R"(<g id="outlines" fill="none" stroke=")", hexadecimal(colour), R"(" stroke-width=")", width,
              "\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n");
    }
    void end_lines() {
        end_path();
        write("</g>\n");
    }

    void begin_group(std::uint32_t feature) { write(R"(<g id="feature-)", std::to_string(feature), "\">\n"); }
    void end_group() { write("</g>\n"); }

    void dot(Point at, double radius, std::size_t layer, std::optional<std::uint32_t> rank) {
        write(R"(<circle class="class-)", std::to_string(layer), R"(" cx=")", at.x, R"(" cy=")", at.y, R"(" r=")",
              radius);
        if (rank) write(R"(" data-rank=")", std::to_string(*rank));
        write("\"/>\n");
    }

    void begin_legend() {
        write(R"(<g id="legend" font-family="DejaVu Sans, Verdana, sans-serif" font-size=")", kFontSize, "\">\n");
    }
    void swatch(Point at, double radius, const Colour& colour) {
        write(R"(<circle cx=")", at.x, R"(" cy=")", at.y, R"(" r=")", radius, R"(" fill=")", hexadecimal(colour),
              "\"/>\n");
    }
    /// Scales text of a usual size, because many programs round sizes of fonts to a pixel.
    void text(Point at, double size, std::string_view words) {
        write(R"(<text transform="translate()", at.x, " ", at.y, ")scale(");
        append_shortest(body_.text(), size / kFontSize);
        write(")\">", escaped(words), "</text>\n");
    }
    void end_legend() { write("</g>\n"); }

    void finish() { write("</svg>\n"); }

private:
    static constexpr double kFontSize = 20;

    void append(std::string_view words) { body_.text() += words; }
    void append(double length) { append_rounded(body_.text(), length, decimals_); }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    Body& body_;
    int decimals_;
    std::size_t corners_ = 0;  ///< of the open path
};

}  // namespace

void write_svg_map(const PointSet& points, const Palette& palette, const Page& page, Body& body,
                   const std::stop_token& stop) {
    SvgMap map(page, body);
    map.begin(points, palette, page);
    draw_map(points, page, page.unit(), map, stop);
    map.finish();
}

}  // namespace ccdt::api

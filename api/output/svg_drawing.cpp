// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_drawing.h"

#include <cstddef>
#include <utility>

#include "api/text/base64.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

std::string_view name_of(Anchor anchor) {
    switch (anchor) {
        case Anchor::Start:
            return "start";
        case Anchor::Middle:
            return "middle";
        case Anchor::End:
            break;
    }
    return "end";
}

}  // namespace

SvgDrawing::SvgDrawing(double width, double height) {
    write(R"(<svg xmlns="http://www.w3.org/2000/svg" width=")", width, R"(" height=")", height, R"(" viewBox="0 0 )",
          width, " ", height, "\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n");
    rectangle({{0, 0}, {width, height}}, R"(fill="#fff")");
}

void SvgDrawing::text(Point at, Anchor anchor, double size, std::string_view words) {
    write("<text x=\"", at.x, "\" y=\"", at.y, "\" font-size=\"", size, "\" text-anchor=\"", name_of(anchor), "\">",
          words, "</text>\n");
}

void SvgDrawing::polyline(std::span<const Point> points, std::string_view style) {
    write("<polyline points=\"");
    for (const Point& p : points) write(p.x, ",", p.y, " ");
    write("\" ", style, "/>\n");
}

void SvgDrawing::line(Point from, Point to, std::string_view style) {
    write("<line x1=\"", from.x, "\" y1=\"", from.y, "\" x2=\"", to.x, "\" y2=\"", to.y, "\" ", style, "/>\n");
}

void SvgDrawing::rectangle(const Box& box, std::string_view style) {
    write("<rect x=\"", box.min.x, "\" y=\"", box.min.y, "\" width=\"", box.width(), "\" height=\"", box.height(),
          "\" ", style, "/>\n");
}

void SvgDrawing::dots(std::span<const Point> centres, double radius) {
    // Discs are drawn as subpaths of zero length with round caps. They take a third of the bytes of circle elements.
    write("<path stroke=\"#000\" stroke-linecap=\"round\" stroke-width=\"", 2 * radius, "\" d=\"");
    for (const Point& centre : centres) write("M", centre.x, " ", centre.y, "h0");
    write("\"/>\n");
}

void SvgDrawing::picture(const Box& box, std::string_view png) {
    write("<image x=\"", box.min.x, "\" y=\"", box.min.y, "\" width=\"", box.width(), "\" height=\"", box.height(),
          R"(" preserveAspectRatio="none" style="image-rendering:pixelated" href="data:image/png;base64,)", base64(png),
          "\"/>\n");
}

void SvgDrawing::begin_clip(const Box& box) {
    write("<svg x=\"", box.min.x, "\" y=\"", box.min.y, "\" width=\"", box.width(), "\" height=\"", box.height(),
          "\" viewBox=\"", box.min.x, " ", box.min.y, " ", box.width(), " ", box.height(), "\">\n");
}

void SvgDrawing::end_clip() {
    write("</svg>\n");
}

std::string SvgDrawing::finish() {
    write("</svg>\n");
    return std::move(out_);
}

/// Appends a length with at most two decimals, without trailing zeros.
void SvgDrawing::append(double length) {
    append_rounded(out_, length, 2);
}

}  // namespace ccdt::api

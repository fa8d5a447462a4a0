// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "api/output/body.h"
#include "api/output/letters.h"
#include "api/output/map_figure.h"
#include "api/output/pen_labels.h"
#include "api/output/plot.h"
#include "api/output/point_set.h"
#include "api/output/ring_curves.h"

// Drawings of shapes in page description languages. The template parameter Paper is a page that is being written, such
// as PdfPage in cairo_drawing.cpp. Coordinates are millimetres from the upper left corner.

namespace ccdt::api {

/// Maximum number of shapes in a path. Viewers are slow to fill longer paths.
inline constexpr std::size_t kChunk = 1'000;

/// Strokes of a pen on a page.
template <class Paper>
class PenStrokes {
public:
    PenStrokes(Paper& page, const Pen& pen) : page_(page), pen_(pen) {}

    bool should_continue() const { return page_.should_continue(); }

    void begin(Point at) {
        page_.move_to(at);
        page_.line_to(at);  // a line of no length, which is a disc because of the round caps
        ++count_;
    }

    void line_to(Point at) { page_.line_to(at); }

    void end() {
        if (count_ % kChunk == 0) draw();
    }

    void draw() { page_.stroke(pen_.colour, pen_.width); }

private:
    Paper& page_;
    const Pen& pen_;
    std::size_t count_ = 0;
};

template <class Paper>
void draw_pen(const Plot& plot, const Pen& pen, Paper& page) {
    if (plot.style != DotStyle::Fill) {
        PenStrokes<Paper> strokes(page, pen);
        for (const PenRun& run : pen.runs) trace(plot, pen, run, strokes);
        return strokes.draw();
    }
    const PageMapping position(plot.page, plot.page.unit());
    for (const PenRun& run : pen.runs) {
        const std::size_t count = run.path.size();
        for (std::size_t i = 0; i < count && page.should_continue(); ++i) {
            page.disc(position(run.points[run.path[i]]), pen.radius);
            if ((i + 1) % kChunk == 0 || i + 1 == count) page.fill(pen.colour);
        }
    }
}

/// Draws the registration marks of a page.
template <class Paper>
void draw_marks(const Page& sheet, const Colour& colour, Paper& page) {
    const std::vector<MarkLine> marks = sheet.marks();
    if (marks.empty()) return;
    for (const auto& [from, to] : marks) {
        page.move_to(from);
        page.line_to(to);
    }
    page.stroke(colour, kMarkWidth);
}

/// Draws the areas of inks. Inks with names are mixed where they overlap.
template <class Paper>
void write_areas(const InkAreas& areas, const Palette& palette, const Page& sheet, Body& body,
                 const std::stop_token& stop) {
    Paper page(sheet.size(), body, stop);
    if (!palette.paper.transparent) page.paper(palette.paper, sheet.drawing());
    const std::vector<std::string> labels = pen_labels(areas.inks);
    for (std::size_t i = 0; i < areas.inks.size(); ++i) {
        if (areas.are_named()) page.begin_ink(labels[i], areas.inks[i].colour, palette.mixing);
        trace_rings(areas.rings[i], sheet.box, PageMapping(sheet, sheet.unit()), page);
        page.fill_even_odd(areas.inks[i].colour);
        draw_marks(sheet, areas.inks[i].colour, page);
        if (areas.are_named()) page.end_ink(palette.mixing);
    }
    page.finish();
}

template <class Paper>
void write_plot(const Plot& plot, const Palette& palette, bool mixes, Body& body, const std::stop_token& stop) {
    body.set_plot(plot.size());
    Paper page(plot.page.size(), body, stop);
    if (plot.style == DotStyle::Fill && !palette.paper.transparent) page.paper(palette.paper, plot.page.drawing());
    for (const Pen& pen : plot.pens) {
        if (mixes) page.begin_ink(pen.label, pen.colour, palette.mixing);
        draw_pen(plot, pen, page);
        draw_marks(plot.page, pen.colour, page);
        if (mixes) page.end_ink(palette.mixing);
    }
    page.finish();
}

/// The medium of draw_map() for a page.
template <class Paper>
class ShapeMap {
public:
    /// @param points  must outlive this object
    ShapeMap(const PointSet& points, Paper& page) : points_(points), page_(page) {}

    bool should_continue() const { return page_.should_continue(); }

    void begin_lines(const Colour& colour, double width) {
        line_colour_ = colour;
        line_width_ = width;
    }
    void begin_line(Point at) {
        if (++lines_ % kChunk == 0) end_lines();
        page_.move_to(at);
    }
    void line_to(Point at) { page_.line_to(at); }
    void end_lines() { page_.stroke(line_colour_, line_width_); }

    void begin_group(std::uint32_t) {}
    void end_group() {}

    void dot(Point at, double radius, std::size_t layer, std::optional<std::uint32_t>) {
        if (layer != layer_ || shapes_ == kChunk) fill();
        layer_ = layer;
        page_.disc(at, radius);
        ++shapes_;
    }
    void begin_legend() { fill(); }
    void end_legend() {}
    void swatch(Point at, double radius, const Colour& colour) {
        page_.disc(at, radius);
        page_.fill(colour);
    }
    void text(Point at, double size, const std::string& words) {
        for (const Ring& ring : letters(words, size)) {
            page_.move_to(at + ring.front());
            for (std::size_t i = 1; i < ring.size(); ++i) page_.line_to(at + ring[i]);
            page_.close();
        }
        page_.fill(kBlack);
    }

    /// Draws the dots that are not drawn yet.
    void fill() {
        if (shapes_ > 0) page_.fill(points_.layers[layer_].ink.colour);
        shapes_ = 0;
    }

private:
    const PointSet& points_;
    Paper& page_;
    Colour line_colour_{};
    double line_width_ = 0;
    std::size_t lines_ = 0;
    std::size_t layer_ = 0;
    std::size_t shapes_ = 0;  ///< number of dots of the layer `layer_` that are not drawn yet
};

/// Draws a map on a page. `unit` and `stop` are those of draw_map().
template <class Paper>
void draw_map_on(Paper& page, const PointSet& points, const Page& sheet, double unit, const std::stop_token& stop) {
    ShapeMap<Paper> map(points, page);
    draw_map(points, sheet, unit, map, stop);
    map.fill();
}

/// Writes dots as shapes. The parameters are those of write_pdf().
template <class Paper>
void write_shapes(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
                  Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    const InkAreas* const areas = points.layers.front().areas;
    if (areas != nullptr) return write_areas<Paper>(*areas, palette, page, body, stop);
    if (points.figure != nullptr) {
        Paper paper(page.size(), body, stop);
        if (!palette.paper.transparent) paper.paper(palette.paper, page.drawing());
        draw_map_on(paper, points, page, page.unit(), stop);
        return paper.finish();
    }
    const Plot plot = plot_of(points, page, drawing, path_stop, stop);
    write_plot<Paper>(plot, palette, points.are_named(), body, stop);
}

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pdf_drawing.h"

#include <cairo-pdf.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "api/output/plot.h"
#include "api/output/ring_curves.h"

namespace ccdt::api {
namespace {

struct Release {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
};

cairo_status_t hand_to(void* body, const unsigned char* data, unsigned size) {
    auto& target = *static_cast<Body*>(body);
    try {
        target.text().append(reinterpret_cast<const char*>(data), size);
        return target.flush() ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
    } catch (const std::exception&) {
        return CAIRO_STATUS_NO_MEMORY;
    }
}

/// PDF document of one page that is being written. Coordinates are millimetres from the upper left corner.
class PdfPage {
public:
    PdfPage(Point size, Body& body, const std::stop_token& stop) : stop_(stop) {
        constexpr double kPoints = 72 / 25.4;  // per millimetre
        surface_.reset(cairo_pdf_surface_create_for_stream(hand_to, &body, kPoints * size.x, kPoints * size.y));
        // With a fixed date, the same drawing has the same bytes at any time.
        cairo_pdf_surface_set_metadata(surface_.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
        context_.reset(cairo_create(surface_.get()));
        cairo_scale(context_.get(), kPoints, kPoints);
        cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_ROUND);
        cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
    }

    void paper(const Colour& colour, const Box& area) {
        if (colour.transparent) return;
        cairo_rectangle(context_.get(), area.min.x, area.min.y, area.width(), area.height());
        fill(colour);
    }

    void marks(const Page& page, const Colour& colour) {
        for (const auto& [from, to] : page.marks()) {
            move_to(from);
            line_to(to);
        }
        stroke(colour, kMarkWidth);
    }

    /// Begins a group. The shapes of a group are first combined with each other; the result is then mixed with what is
    /// below.
    void begin_group() { cairo_push_group(context_.get()); }

    void end_group(Mixing mixing) {
        cairo_pop_group_to_source(context_.get());
        if (mixing == Mixing::Multiply) cairo_set_operator(context_.get(), CAIRO_OPERATOR_MULTIPLY);
        if (mixing == Mixing::Add) cairo_set_operator(context_.get(), CAIRO_OPERATOR_SCREEN);
        cairo_paint(context_.get());
        cairo_set_operator(context_.get(), CAIRO_OPERATOR_OVER);
    }

    /// Adds a disc made of four cubic curves. The relative error of its radius is below 0.0003.
    void disc(Point centre, double radius) {
        constexpr double kArm = 0.5522847498307936;
        Point out{radius, 0};
        move_to(centre + out);
        for (int quarter = 0; quarter < 4; ++quarter) {
            const Point next{-out.y, out.x};
            const Point first = centre + out + kArm * next, second = centre + next + kArm * out, end = centre + next;
            cairo_curve_to(context_.get(), first.x, first.y, second.x, second.y, end.x, end.y);
            out = next;
        }
        close();
    }

    void fill(const Colour& colour) {
        choose(colour);
        cairo_fill(context_.get());
    }

    void stroke(const Colour& colour, double width) {
        choose(colour);
        cairo_set_line_width(context_.get(), width);
        cairo_stroke(context_.get());
    }

    void move_to(Point p) { cairo_move_to(context_.get(), p.x, p.y); }
    void line_to(Point p) { cairo_line_to(context_.get(), p.x, p.y); }

    /// Adds a quadratic curve, converted exactly to a cubic one.
    void curve_to(Point control, Point end) {
        Point begin;
        cairo_get_current_point(context_.get(), &begin.x, &begin.y);
        const Point first = begin + (2.0 / 3) * (control - begin);
        const Point second = end + (2.0 / 3) * (control - end);
        cairo_curve_to(context_.get(), first.x, first.y, second.x, second.y, end.x, end.y);
    }

    void close() { cairo_close_path(context_.get()); }

    void fill_even_odd(const Colour& colour) {
        cairo_set_fill_rule(context_.get(), CAIRO_FILL_RULE_EVEN_ODD);
        fill(colour);
    }

    bool should_continue() const { return !stop_.stop_requested(); }

    void finish() {
        cairo_surface_finish(surface_.get());
        if (cairo_surface_status(surface_.get()) == CAIRO_STATUS_NO_MEMORY ||
            cairo_status(context_.get()) == CAIRO_STATUS_NO_MEMORY)
            throw std::bad_alloc();
    }

private:
    void choose(const Colour& colour) {
        cairo_set_source_rgb(context_.get(), colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
    }

    const std::stop_token& stop_;
    std::unique_ptr<cairo_surface_t, Release> surface_;
    std::unique_ptr<cairo_t, Release> context_;
};

/// Maximum number of shapes in a path. Viewers are slow to fill longer paths.
constexpr std::size_t kChunk = 1'000;

/// Strokes of a pen on a page.
class PdfStrokes {
public:
    PdfStrokes(PdfPage& page, const Pen& pen) : page_(page), pen_(pen) {}

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
    PdfPage& page_;
    const Pen& pen_;
    std::size_t count_ = 0;
};

void draw_pen(const Plot& plot, const Pen& pen, PdfPage& page) {
    if (plot.style != DotStyle::Fill) {
        PdfStrokes strokes(page, pen);
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

/// Draws the areas of inks. Inks with names are mixed where they overlap.
void write_areas(const InkAreas& areas, const Palette& palette, const Page& sheet, Body& body,
                 const std::stop_token& stop) {
    PdfPage page(sheet.size(), body, stop);
    page.paper(palette.paper, sheet.drawing());
    for (std::size_t i = 0; i < areas.inks.size(); ++i) {
        if (areas.are_named()) page.begin_group();
        trace_rings(areas.rings[i], sheet.box, PageMapping(sheet, sheet.unit()), page);
        page.fill_even_odd(areas.inks[i].colour);
        page.marks(sheet, areas.inks[i].colour);
        if (areas.are_named()) page.end_group(palette.mixing);
    }
    page.finish();
}

void write_plot(const Plot& plot, const Palette& palette, bool mixes, Body& body, const std::stop_token& stop) {
    body.set_plot(plot.size());
    PdfPage page(plot.page.size(), body, stop);
    if (plot.style == DotStyle::Fill) page.paper(palette.paper, plot.page.drawing());
    for (const Pen& pen : plot.pens) {
        if (mixes) page.begin_group();
        draw_pen(plot, pen, page);
        page.marks(plot.page, pen.colour);
        if (mixes) page.end_group(palette.mixing);
    }
    page.finish();
}

}  // namespace

void write_pdf(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    const InkAreas* const areas = points.layers.front().areas;
    if (areas != nullptr) return write_areas(*areas, palette, page, body, stop);
    write_plot(plot_of(points, page, drawing, path_stop, stop), palette, points.are_named(), body, stop);
}

}  // namespace ccdt::api

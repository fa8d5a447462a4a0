// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pdf_drawing.h"

#include <cairo-pdf.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "api/output/shape_drawing.h"

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
        cairo_rectangle(context_.get(), area.min.x, area.min.y, area.width(), area.height());
        fill(colour);
    }

    /// Begins the group of an ink. The shapes of a group are first combined with each other; the result is then mixed
    /// with what is below.
    void begin_ink(const std::string&, const Colour&, Mixing) { cairo_push_group(context_.get()); }

    void end_ink(Mixing mixing) {
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

}  // namespace

void write_pdf(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    write_shapes<PdfPage>(points, palette, page, drawing, body, path_stop, stop);
}

}  // namespace ccdt::api

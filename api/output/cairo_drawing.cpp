// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/cairo_drawing.h"

#include <cairo-pdf.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>

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

using Surface = std::unique_ptr<cairo_surface_t, Release>;
using Context = std::unique_ptr<cairo_t, Release>;

/// Page that Cairo draws. Coordinates are relative to the upper left corner.
class CairoPage {
public:
    /// @param unit  units of the surface per unit of the page
    CairoPage(Surface surface, double unit, const std::stop_token& stop) : stop_(stop), surface_(std::move(surface)) {
        context_.reset(cairo_create(surface_.get()));
        cairo_scale(context_.get(), unit, unit);
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

    /// Completes the page. Throws std::bad_alloc if memory ran out.
    void finish() {
        cairo_surface_flush(surface_.get());
        if (cairo_surface_status(surface_.get()) == CAIRO_STATUS_NO_MEMORY ||
            cairo_status(context_.get()) == CAIRO_STATUS_NO_MEMORY)
            throw std::bad_alloc();
    }

    cairo_surface_t* surface() const { return surface_.get(); }

private:
    void choose(const Colour& colour) {
        cairo_set_source_rgb(context_.get(), colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
    }

    const std::stop_token& stop_;
    Surface surface_;
    Context context_;
};

constexpr double kPoints = 72 / 25.4;  ///< per millimetre

Surface pdf_surface(Point size, Body& body) {
    Surface surface(cairo_pdf_surface_create_for_stream(hand_to, &body, kPoints * size.x, kPoints * size.y));
    // With a fixed date, the same drawing has the same bytes at any time.
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
    return surface;
}

/// PDF document of one page that is being written. Coordinates are millimetres.
class PdfPage : public CairoPage {
public:
    PdfPage(Point size, Body& body, const std::stop_token& stop) : CairoPage(pdf_surface(size, body), kPoints, stop) {}

    void finish() {
        cairo_surface_finish(surface());
        CairoPage::finish();
    }
};

/// Returns the pixels of a surface of the format RGB24.
DotImage picture_on(cairo_surface_t* surface) {
    DotImage picture;
    picture.width = cairo_image_surface_get_width(surface);
    picture.height = cairo_image_surface_get_height(surface);
    picture.pixels.reserve(static_cast<std::size_t>(picture.height) * picture.row_size());
    const unsigned char* row = cairo_image_surface_get_data(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    for (int y = 0; y < picture.height; ++y, row += stride) {
        for (int x = 0; x < picture.width; ++x) {
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, row + std::size_t{4} * static_cast<std::size_t>(x), sizeof pixel);
            for (const int shift : {16, 8, 0}) picture.pixels.push_back(static_cast<std::uint8_t>(pixel >> shift));
        }
    }
    return picture;
}

}  // namespace

Result<DotImage> picture_of_map(const PointSet& points, const Palette& palette, const Page& page,
                                const std::stop_token& stop) {
    CairoPage paper(Surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, page.canvas.width, page.canvas.height)), 1,
                    stop);
    paper.paper(palette.paper.transparent ? kWhite : palette.paper,
                {{0, 0}, {static_cast<double>(page.canvas.width), static_cast<double>(page.canvas.height)}});
    draw_map_on(paper, points, page, page.canvas.scale, stop);
    paper.finish();
    return picture_on(paper.surface());
}

void write_pdf(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    write_shapes<PdfPage>(points, palette, page, drawing, body, path_stop, stop);
}

}  // namespace ccdt::api

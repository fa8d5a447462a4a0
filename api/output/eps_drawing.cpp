// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/eps_drawing.h"

#include <cmath>
#include <string>
#include <string_view>

#include "api/output/shape_drawing.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

/// Returns the name of a spot colour as a string of PostScript. Begins with a capital letter, so that the colours of
/// process inks have the names that printers know.
std::string spot_name(std::string name) {
    if (!name.empty() && name[0] >= 'a' && name[0] <= 'z') name[0] = static_cast<char>(name[0] - 'a' + 'A');
    if (name == "All" || name == "None") name += " ink";  // PostScript gives these names a meaning
    std::string text = "(";
    for (const char c : name) {
        if (c == '(' || c == ')' || c == '\\') text += '\\';
        text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return text += ')';
}

/// EPS document that is being written. Has the members of PdfPage.
class EpsPage {
public:
    EpsPage(Point size, Body& body, const std::stop_token& stop) : body_(body), stop_(stop) {
        constexpr double kPoints = 72 / 25.4;  // per millimetre
        const Point points = kPoints * size;
        write("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 ", std::ceil(points.x), " ", std::ceil(points.y));
        write("\n%%HiResBoundingBox: 0 0 ", points.x, " ", points.y, "\n%%LanguageLevel: 2\n%%EndComments\n");
        // The operators have the names of those of PDF.
        write(
            "20 dict begin\n/m{moveto}bind def/l{lineto}bind def/c{curveto}bind def/h{closepath}bind def\n"
            "/d{3 copy exch 3 1 roll add exch moveto 0 360 arc closepath}bind def\n"
            "/rg{setrgbcolor}bind def/f{fill}bind def/F{eofill}bind def/S{setlinewidth stroke}bind def\n"
            "gsave 72 25.4 div dup neg scale 0 ",
            -size.y, " translate 1 setlinecap 1 setlinejoin\n");
    }

    void paper(const Colour& colour, const Box& area) {
        move_to(area.min);
        line_to({area.max.x, area.min.y});
        line_to(area.max);
        line_to({area.min.x, area.max.y});
        close();
        fill(colour);
    }

    /// Begins to draw with an ink.
    void begin_ink(const std::string& label, const Colour& colour, Mixing mixing) {
        is_spot_ = mixing == Mixing::Multiply;
        if (!is_spot_) return;
        write("[/Separation", spot_name(label), "cvn/DeviceRGB{dup ", 1 - colour.red / 255.0,
              " mul 1 exch sub exch dup ", 1 - colour.green / 255.0, " mul 1 exch sub exch ", 1 - colour.blue / 255.0,
              " mul 1 exch sub}]setcolorspace 1 setcolor true setoverprint\n");
    }

    void end_ink(Mixing) {
        if (is_spot_) write("false setoverprint\n");
        is_spot_ = false;
    }

    void disc(Point centre, double radius) { write(centre, radius, " d\n"); }

    void fill(const Colour& colour) {
        choose(colour);
        write("f\n");
    }

    void fill_even_odd(const Colour& colour) {
        choose(colour);
        write("F\n");
    }

    void stroke(const Colour& colour, double width) {
        choose(colour);
        write(width, " S\n");
    }

    void move_to(Point p) {
        write(p, "m\n");
        at_ = p;
    }

    void line_to(Point p) {
        write(p, "l\n");
        at_ = p;
    }

    /// Adds a quadratic curve, converted exactly to a cubic one.
    void curve_to(Point control, Point end) {
        write(at_ + (2.0 / 3) * (control - at_), end + (2.0 / 3) * (control - end), end, "c\n");
        at_ = end;
    }

    void close() { write("h\n"); }

    bool should_continue() const { return body_.flush() && !stop_.stop_requested(); }

    void finish() { write("grestore end showpage\n%%EOF\n"); }

private:
    void choose(const Colour& colour) {
        if (!is_spot_) write(colour.red / 255.0, " ", colour.green / 255.0, " ", colour.blue / 255.0, " rg ");
        body_.flush();
    }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    void append(std::string_view words) { body_.text() += words; }
    void append(double number) { append_fixed(body_.text(), number, 3); }
    void append(Point p) { write(p.x, " ", p.y, " "); }

    Body& body_;
    const std::stop_token& stop_;
    Point at_{};
    bool is_spot_ = false;
};

}  // namespace

void write_eps(const PointSet& points, const Palette& palette, const Page& page, const DrawingOptions& drawing,
               Body& body, const std::stop_token& path_stop, const std::stop_token& stop) {
    write_shapes<EpsPage>(points, palette, page, drawing, body, path_stop, stop);
}

}  // namespace ccdt::api

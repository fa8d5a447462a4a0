// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "api/input/drawing_options.h"
#include "core/base/result.h"
#include "core/geometry/point.h"
#include "core/halftone/dots/dots.h"

namespace ccdt::api {

/// Paper around a drawing.
struct Sheet {
    Point size;          ///< mm
    Point corner;        ///< upper left corner of the drawing, in mm from that of the paper
    bool marks = false;  ///< whether each pen draws registration marks
};

/// Width of the lines of registration marks in SVG and PDF, mm.
inline constexpr double kMarkWidth = 0.25;

/// Line of a registration mark, in user units of the page.
struct MarkLine {
    Point from, to;
};

/// Page of a drawing. A box in the plane of the points is mapped to the whole page, or to a part of its paper.
struct Page {
    Box box;                ///< in the units of the points; its sides are positive and finite
    bool y_up = false;      ///< whether the points' y axis points up; on the page, it always points down
    bool periodic = false;  ///< whether the box is a torus
    Canvas canvas = {};     ///< size in pixels, and pixels per unit of the points
    std::optional<double> width_mm = {};
    bool along_path = true;           ///< whether dots are drawn along a short path; if false, in the given order
    std::optional<Sheet> sheet = {};  ///< requires `width_mm`; none: the page is as large as the drawing

    /// Returns the number of user units per unit of the points. User units are millimetres if the page has a width in
    /// millimetres.
    double unit() const { return width_mm ? *width_mm / box.width() : 1; }
    /// Returns the position of the drawing on the page.
    Box drawing() const {
        const Point corner = sheet ? sheet->corner : Point{};
        return {corner, corner + unit() * Point{box.width(), box.height()}};
    }
    Point size() const { return sheet ? sheet->size : drawing().max; }

    /// Returns the lines of the registration marks: four crosses between the corners of the drawing and of the paper.
    std::vector<MarkLine> marks() const;
};

/// Sets the width and the paper of a page from the options of a drawing. Without a given width, the drawing is as large
/// as the margins allow. It lies in the middle of the paper.
/// Errors: Unusable if the drawing or its marks do not fit; Error::field is the name of an option.
Result<void> place_on_paper(const DrawingOptions& options, Page& page);

/// Maps points to positions on the page, relative to the upper left corner of the page.
class PageMapping {
public:
    /// @param page  must outlive this object
    /// @param unit  length on the page of one unit of the points
    PageMapping(const Page& page, double unit)
        : page_(page), unit_(unit), corner_((unit / page.unit()) * page.drawing().min) {}

    Point operator()(Point p) const {
        const Box& box = page_.box;
        return corner_ + Point{(p.x - box.min.x) * unit_, (page_.y_up ? box.max.y - p.y : p.y - box.min.y) * unit_};
    }

private:
    const Page& page_;
    double unit_;
    Point corner_;  ///< of the drawing
};

}  // namespace ccdt::api

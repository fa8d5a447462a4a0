// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "core/geometry/point.h"
#include "core/halftone/dots/dots.h"

namespace ccdt::api {

/// Page of a drawing. A box in the plane of the points is mapped to the whole page.
struct Page {
    Box box;                ///< in the units of the points; its sides are positive and finite
    bool y_up = false;      ///< whether the points' y axis points up; on the page, it always points down
    bool periodic = false;  ///< whether the box is a torus
    Canvas canvas;          ///< size in pixels, and pixels per unit of the points
    std::optional<double> width_mm;
    bool along_path = true;  ///< whether dots are drawn along a short path; if false, in the given order

    /// Returns the number of user units per unit of the points. User units are millimetres if the page has a width in
    /// millimetres.
    double unit() const { return width_mm ? *width_mm / box.width() : 1; }
    Point size() const { return {box.width() * unit(), box.height() * unit()}; }
};

/// Maps points to positions on the page, relative to the upper left corner of the page.
class PageMapping {
public:
    /// @param page  must outlive this object
    /// @param unit  length on the page of one unit of the points
    PageMapping(const Page& page, double unit) : page_(page), unit_(unit) {}

    Point operator()(Point p) const {
        const Box& box = page_.box;
        return {(p.x - box.min.x) * unit_, (page_.y_up ? box.max.y - p.y : p.y - box.min.y) * unit_};
    }

private:
    const Page& page_;
    double unit_;
};

}  // namespace ccdt::api

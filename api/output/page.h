// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "core/geometry/point.h"
#include "core/halftone/dots.h"

namespace ccdt::api {

/// Sheet that shows a box all over.
struct Page {
    Box box;                ///< in the points' units; its sides as those of a Domain
    bool y_up = false;      ///< the points' y runs up; on the page it always runs down
    bool periodic = false;  ///< the box is a torus
    Canvas canvas;          ///< its size in pixels, its scale in pixels per unit of the points
    std::optional<double> width_mm;
    bool along_path = true;  ///< dots are drawn along a short path, else in the order that they come in

    /// User units of a drawing per unit of the points: millimetres if the page has a width in these.
    double unit() const { return width_mm ? *width_mm / box.width() : 1; }
    Point size() const { return {box.width() * unit(), box.height() * unit()}; }
};

/// Mapping of points to the page, from its upper left corner.
class Placing {
public:
    /// @param page  must outlive it
    /// @param unit  length on the page of a unit of the points
    Placing(const Page& page, double unit) : page_(page), unit_(unit) {}

    Point operator()(Point p) const {
        const Box& box = page_.box;
        return {(p.x - box.min.x) * unit_, (page_.y_up ? box.max.y - p.y : p.y - box.min.y) * unit_};
    }

private:
    const Page& page_;
    double unit_;
};

}  // namespace ccdt::api

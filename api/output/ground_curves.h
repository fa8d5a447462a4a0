// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "api/output/page.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Draws the rings around black ground as closed curves. A curve is a quadratic spline whose control points are the
/// points of the ring. Along the border of the page, the curve is straight.
/// @param sink  has move_to(point), line_to(point), curve_to(control, end) and close(); points are on the page
template <class Sink>
void trace_ground(std::span<const std::vector<Point>> rings, const Page& page, Sink& sink) {
    const PageMapping place(page, page.unit());
    const auto is_on_border = [&](Point p) {
        return p.x <= page.box.min.x || p.y <= page.box.min.y || p.x >= page.box.max.x || p.y >= page.box.max.y;
    };
    for (const std::vector<Point>& ring : rings) {
        const auto middle = [&](std::size_t i) { return place(0.5 * (ring[i] + ring[(i + 1) % ring.size()])); };
        sink.move_to(middle(ring.size() - 1));
        for (std::size_t i = 0; i < ring.size(); ++i) {
            if (is_on_border(ring[i])) {
                sink.line_to(place(ring[i]));
                sink.line_to(middle(i));
            } else {
                sink.curve_to(place(ring[i]), middle(i));
            }
        }
        sink.close();
    }
}

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Draws rings as smooth curves that enclose the same area, to about 1 %. A curve is a quadratic spline with a control
/// point for each corner of the ring, a little further out. At the sides of the box, the curve is straight.
/// @param position  maps a corner to the drawing
/// @param sink      has move_to(point), line_to(point), curve_to(control, end) and close()
template <class Position, class Sink>
void trace_rings(std::span<const std::vector<Point>> rings, const Box& box, const Position& position, Sink& sink) {
    // For regular rings of 4 to 8 corners, 0.095 to 0.087 keep the area exactly.
    constexpr double kOutwards = 0.09;
    for (const std::vector<Point>& ring : rings) {
        const std::size_t count = ring.size();
        const auto is_straight = [&](Point p) {
            return p.x <= box.min.x || p.y <= box.min.y || p.x >= box.max.x || p.y >= box.max.y;
        };
        const auto control = [&](std::size_t i) {
            const Point corner = ring[i % count];
            if (is_straight(corner)) return corner;
            return corner + kOutwards * (corner - 0.5 * (ring[(i + count - 1) % count] + ring[(i + 1) % count]));
        };
        const auto middle = [&](std::size_t i) { return position(0.5 * (control(i) + control(i + 1))); };
        sink.move_to(middle(count - 1));
        for (std::size_t i = 0; i < count; ++i) {
            if (is_straight(ring[i])) {
                sink.line_to(position(ring[i]));
                sink.line_to(middle(i));
            } else {
                sink.curve_to(position(control(i)), middle(i));
            }
        }
        sink.close();
    }
}

}  // namespace ccdt::api

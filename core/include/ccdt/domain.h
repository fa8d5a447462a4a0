// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <variant>
#include <vector>

#include "ccdt/abi.h"

namespace ccdt::v2 {

struct Point {
    double x = 0;
    double y = 0;

    friend bool operator==(const Point&, const Point&) = default;
};

/// Corners of a closed chain of segments, in either direction. The last corner is joined to the first, and may equal
/// it.
using Ring = std::vector<Point>;

/// A polygon with holes. Coordinates must be finite.
struct Polygon {
    Ring outer;
    std::vector<Ring> holes = {};
};

/// The rectangle [0, width] x [0, height]. The sides must be positive and finite.
struct Rectangle {
    double width = 0;
    double height = 0;
};

/// The torus [0, width) x [0, height), a rectangle whose opposite sides are joined, so that copies of a pattern on it
/// tile the plane. The sides must be positive and finite, and one at most 1000 times the other.
struct Torus {
    double width = 0;
    double height = 0;
};

/// A region of the plane. Several polygons form their union.
///
/// The longer side of the bounding box must be from 1e-140 to 1e140, and no coordinate may exceed 1e9 times this side.
using Domain = std::variant<Polygon, std::vector<Polygon>, Rectangle, Torus>;

}  // namespace ccdt::v2

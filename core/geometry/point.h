// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/pair.h"

namespace ccdt {

struct Point {
    double x = 0;
    double y = 0;

    friend bool operator==(const Point&, const Point&) = default;
    friend Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
    friend Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
    friend Point operator*(double s, Point a) { return {s * a.x, s * a.y}; }
};

inline double cross(Point a, Point b) {
    return a.x * b.y - a.y * b.x;
}
inline double dot(Point a, Point b) {
    return a.x * b.x + a.y * b.y;
}

inline Pair load(const Point& p) {
    return Pair{p.x, p.y};
}

/// Corner coordinates below this value, in the unit frame, count as 0. It is far below the rounding error of points.
inline constexpr double kMinCoordinate = 0x1p-100;

/// Adding and then subtracting this value rounds numbers in [-2, 2) to multiples of 2^-50. Sums of such multiples are
/// exact.
inline constexpr double kSnapping = 6;

inline Point snapped(Point p) {
    return {(p.x + kSnapping) - kSnapping, (p.y + kSnapping) - kSnapping};
}

/// Returns the periodic copy of x in [0, period).
inline double wrapped(double x, double period) {
    const double inside = x - std::floor(x / period) * period;
    return inside < period ? inside : 0;
}

/// Returns the periodic copy of p in the box of a torus.
inline Point wrapped(Point p, Point period) {
    return {wrapped(p.x, period.x), wrapped(p.y, period.y)};
}

/// A closed axis-parallel box.
struct Box {
    Point min;
    Point max;

    double width() const { return max.x - min.x; }
    double height() const { return max.y - min.y; }

    /// Grows the box to include a point.
    void include(Point p) {
        min = {std::min(min.x, p.x), std::min(min.y, p.y)};
        max = {std::max(max.x, p.x), std::max(max.y, p.y)};
    }
};

}  // namespace ccdt

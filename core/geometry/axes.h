// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Number of coordinates of a Point or a Point3.
template <class P>
inline constexpr std::size_t kAxes = sizeof(P) / sizeof(double);

/// Returns the coordinate of a point along an axis (0, 1 or 2).
inline double& along(Point& p, std::size_t axis) {
    return axis == 0 ? p.x : p.y;
}
inline double along(const Point& p, std::size_t axis) {
    return axis == 0 ? p.x : p.y;
}
inline double& along(Point3& p, std::size_t axis) {
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}
inline double along(const Point3& p, std::size_t axis) {
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// Returns the point whose coordinate along each axis is function(axis).
template <class P, class Function>
P by_axis(Function&& function) {
    const auto at = [&](int axis) { return function(static_cast<std::size_t>(axis)); };
    if constexpr (kAxes<P> == 2) return {at(0), at(1)};
    if constexpr (kAxes<P> == 3) return {at(0), at(1), at(2)};
}

}  // namespace ccdt

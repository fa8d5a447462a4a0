#pragma once

#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// An edge of an area's border, the area on its left.
struct BorderEdge {
    Point from, to;
    double weight = 1;  ///< by which the area counts; the same all around it
};

/// Share of each cell of a grid that areas cover, each times its weight, to rounding [rows * columns].
/// @param sides  of the box that the grid is stretched over, its corner at the origin
/// O(cells + those that the border crosses).
std::vector<double> coverage(std::span<const BorderEdge> border, Point sides, int columns, int rows);

}  // namespace ccdt

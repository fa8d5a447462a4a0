// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/geometry/point3.h"

namespace ccdt {

/// Whether the surface between two faces has a sharp edge: their normals are about 90 degrees apart or more. Across a
/// sharp edge, straight lines in space are much shorter than lines on the surface, and may even point away from the
/// edge.
/// @param first, second  normals of unit length
inline bool is_sharp(Point3 first, Point3 second) {
    constexpr double kMargin = 1e-6;  // of the cosine; so that rounding does not decide about the edges of a box
    return dot(first, second) < kMargin;
}

/// Returns the vector from a point of one face to a point of another one if the surface between the two faces has a
/// sharp edge: the second face is rotated into the plane of the first one, about the line in which the two planes
/// intersect. Returns the straight vector if the planes are nearly parallel, or if the line is not between the points,
/// as at the rim of a thin plate.
/// @param straight       vector in space
/// @param first, second  normals of the faces
inline Point3 unfolded(Point3 straight, Point3 first, Point3 second) {
    constexpr double kLeastSquaredSine = 0.02;
    const double cosine = dot(first, second), squared_sine = 1 - cosine * cosine;
    // Distances of the points from the plane of the other point, times the sign of the fold, which is convex or
    // concave.
    const double before = dot(straight, second), after = -dot(straight, first);
    if (squared_sine < kLeastSquaredSine || before * after < 0) return straight;
    const Point3 line = cross(first, second);
    return 1 / squared_sine * (dot(straight, line) * line + (before + after) * (second - cosine * first));
}

}  // namespace ccdt

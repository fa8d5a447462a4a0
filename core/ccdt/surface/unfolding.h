// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/ccdt/surface/surface.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Cosine between the normals of two faces below which their edge is sharp: about 0, so that rounding does not decide
/// about the edges of a box.
inline constexpr double kSharpCosine = 1e-6;

/// Whether the surface between two faces has a sharp edge: their normals are about 90 degrees apart or more. Across a
/// sharp edge, straight lines in space are much shorter than lines on the surface, and may even point away from the
/// edge.
/// @param first, second  normals of unit length
inline bool is_sharp(Point3 first, Point3 second) {
    return dot(first, second) < kSharpCosine;
}

/// Returns for each component of a surface whether any of its edges is sharp.
std::vector<std::uint8_t> sharp_components(const Surface& surface);

/// A vector between two points of a surface, after the second face was rotated into the plane of the first one.
struct Unfolded {
    Point3 vector;
    bool crosses_sharp_edge;  ///< otherwise the surface has a bend between the points
};

/// Returns the vector from a point of a surface to another one, whose faces are at a sharp angle: the second face is
/// rotated into the plane of the first one, about the line in which the two planes intersect. Returns none if the line
/// with this direction and length on the surface does not end near the second point, as around a thin tube. A line over
/// many faces is not checked, and counts as one that crosses a sharp edge.
/// @param straight  vector from the first point to the second one in space
/// @param face      face of the second point
/// @param longest   length above which there is no result
/// O(1).
std::optional<Unfolded> unfolded(const Surface& surface, const SurfacePoint& from, Point3 straight, std::uint32_t face,
                                 double longest);

}  // namespace ccdt

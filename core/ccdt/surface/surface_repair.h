// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/surface/surface_note.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Triangles that form an oriented surface: every edge belongs to one or two triangles, neighbours have the same
/// orientation, and the triangles around each vertex form one fan.
struct ConnectedTriangles {
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    /// Largest number of triangles, because half-edges have 32-bit numbers.
    static constexpr std::size_t kMaxTriangles = std::size_t{1} << 30;

    struct Face {
        std::array<std::uint32_t, 3> corners{};
        std::array<std::uint32_t, 3> twins{kNone, kNone, kNone};  ///< half-edges, as in Surface
        std::uint32_t triangle = 0;                               ///< index of the given triangle
        bool turned = false;                                      ///< whether the last two corners were swapped
        bool flat = false;                                        ///< whether is_flat()
    };

    std::vector<Point3> vertices;
    std::vector<Face> faces;  ///< along Morton's curve, so that neighbours are close in memory
    std::vector<SurfaceNote> repairs;

    /// Returns the normal of a triangle, with twice the triangle's area as its length.
    static Point3 doubled_area(const std::array<Point3, 3>& triangle);
    /// Whether the corners of a triangle are on one line, up to rounding.
    static bool is_flat(const std::array<Point3, 3>& triangle);
};

/// Makes a surface from triangles. Vertices at the same position become one vertex. Triangles whose corners have fewer
/// than three positions are removed, so that their neighbours become adjacent. Flat triangles with three positions
/// remain as faces, because their removal would leave cracks. They are removed only if more than two triangles share
/// one of their edges, if their longest edge is on a border, or if all connected triangles are flat. Of repeated
/// triangles, the first remains. Walls between two parts, such as the common face of two boxes, are removed.
/// If more than two triangles share an edge, the pairs that bound the inside remain connected. If the orientations
/// contradict each other, none of these triangles remain connected, and the edge becomes a border. The surface is also
/// cut along edges that prevent a consistent orientation. Of connected triangles with different orientations, the
/// minority is turned. Then a closed surface is turned as a whole if it encloses a negative volume, unless it is inside
/// another closed surface, because it may bound a cavity. A vertex with several fans becomes several vertices.
///
/// CGAL's orient_polygon_soup() is similar, but its time is quadratic in the number of triangles at a vertex, and it
/// does not report all cuts.
/// @param positions  multiples of 2^-36 in [0, 1], so that differences are exact
/// @param triangles  every index is valid; at most kMaxTriangles
///
/// Errors: Stopped. The result may have no faces. Deterministic. O(n log n), with about 130 bytes per triangle.
Result<ConnectedTriangles> connect_triangles(std::span<const Point3> positions,
                                             std::span<const std::array<std::uint32_t, 3>> triangles,
                                             const std::stop_token& stop);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// A triangle, and the triangles beside it.
struct WallFace {
    std::array<std::uint32_t, 3> corners;  ///< indices of positions
    std::array<std::uint32_t, 3> twins;    ///< half-edges, as in Surface; kNone where not exactly two faces meet
};

/// A side of an edge that more than two faces share.
struct CrowdedSide {
    std::uint32_t edge;       ///< number of the edge; consecutive sides have the same edge or a greater one
    std::uint32_t half_edge;  ///< of a face
};

/// Finds walls between two parts of a surface, such as the common face of two boxes: two plane patches of faces with
/// the same border and opposite orientations, which may be divided differently. Each edge on the border of a wall also
/// belongs to two other faces, one of each part. So the two sides of a thin sheet are not a wall.
/// @param sides  all sides of edges that more than two faces share
///
/// Returns the faces of both sides of the walls. Deterministic. O(faces + sides log sides).
std::vector<std::uint32_t> party_walls(std::span<const Point3> positions, std::span<const WallFace> faces,
                                       std::span<const CrowdedSide> sides);

}  // namespace ccdt

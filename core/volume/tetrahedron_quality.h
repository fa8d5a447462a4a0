// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

#include "core/geometry/point3.h"
#include "core/volume/tetrahedron_mesh.h"

namespace ccdt {

/// Makes small dihedral angles larger: moves vertices, and replaces the tetrahedra around edges and beside faces. The
/// mesh fills the same domain as before. It is no longer Delaunay.
/// @param periods  sides of a torus, which is at least six edges wide; 0 for other domains
/// @param slide    returns the place of a vertex that ought to move: the vertex's own place if it is fixed, or a place
///                 on the surface if it lies there
/// @param stop     a stop leaves a valid mesh
///
/// Deterministic. O(tetrahedra), about 100 bytes per tetrahedron.
/// Source: Freitag, Ollivier-Gooch, Tetrahedral mesh improvement using swapping and smoothing, 1997. Departure:
/// vertices descend on the sum of the cubed mean ratios, which is smooth.
void improve_tetrahedra(TetrahedronMesh& mesh, Point3 periods,
                        const std::function<Point3(std::uint32_t vertex, Point3 to)>& slide,
                        const std::stop_token& stop);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

#include "core/ccdt/volume/tetrahedron_mesh.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Makes small dihedral angles larger: moves vertices, and replaces the tetrahedra around edges. The mesh fills the
/// same domain as before, up to bends of a curved surface. It is no longer a Delaunay triangulation.
/// @param periods  sides of a torus, which is at least six edges wide; 0 for other domains
/// @param slide    returns the position to which a vertex may move instead of `to`: its own position if it is fixed, or
///                 a position on the surface if the vertex lies there
/// @param stop     polled regularly; a stop leaves a valid mesh
///
/// Deterministic. O(tetrahedra), about 100 bytes per tetrahedron.
/// Source: Freitag, Ollivier-Gooch, Tetrahedral mesh improvement using swapping and smoothing, 1997. Departures:
/// vertices descend on a smooth energy, the sum of (sum of squared edges)^3 / volume^2. Faces are not removed, because
/// that would gain nothing after the removal of edges.
void improve_tetrahedra(TetrahedronMesh& mesh, Point3 periods,
                        const std::function<Point3(std::uint32_t vertex, Point3 to)>& slide,
                        const std::stop_token& stop);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "core/geometry/point3.h"
#include "core/volume/volume_mesh.h"

namespace ccdt {

/// Places the tetrahedra of a torus in space, for programs that know no tori. The first corner of each tetrahedron
/// stays where it is, and the others become the nearest of their periodic copies. Copies beyond the border are further
/// vertices.
/// @param sides  sides of the torus
/// @returns      none if an edge is longer than half a side, so that the nearest copies are the wrong ones
///
/// The tetrahedra together have the volume of the torus. O(vertices + tetrahedra log copies).
std::optional<TetrahedronMesh> unwrapped(const TetrahedronMesh& mesh, Point3 sides);

}  // namespace ccdt

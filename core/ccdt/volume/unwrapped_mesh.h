// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "core/ccdt/volume/volume_mesh.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Unwraps the tetrahedra of a torus, for programs that do not support tori. The first corner of each tetrahedron keeps
/// its position, and each other corner becomes its nearest periodic copy. Copies beyond the border are additional
/// vertices.
/// @param sides  sides of the torus
/// @returns      none if the tetrahedra do not have the volume of the torus together: edges longer than half a side
///               have the wrong copies as corners
///
/// Deterministic. O(vertices + tetrahedra log copies).
std::optional<TetrahedronMesh> unwrapped(const TetrahedronMesh& mesh, Point3 sides);

}  // namespace ccdt

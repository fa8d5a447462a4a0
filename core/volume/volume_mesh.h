// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "core/geometry/point3.h"
#include "core/volume/box_domain3.h"
#include "core/volume/tetrahedron_mesh.h"
#include "core/volume/volume_spacing.h"

namespace ccdt {

/// Triangulates points by a Delaunay triangulation, which improve_tetrahedra() improves. In a box, each point of the
/// first layer has further vertices where it is projected to the faces and edges near it, and the corners of the box
/// are vertices, too.
/// @param points  in the domain; the first `free` of them may move, to make small dihedral angles larger
/// @param stop    after a stop, the mesh must not be used
///
/// O(points log points).
TetrahedronMesh volume_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/tetrahedron_mesh.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Computes the Delaunay triangulation of points and improves it by improve_tetrahedra(), except on a torus that is
/// narrower than six spacings. In a box, the projections of the first layer of points to the faces and edges near them
/// are vertices, too, and so are the corners of the box.
/// @param points  in the domain; the vertices of the first `free` of them may be moved, to make small dihedral angles
///                larger
/// @param stop    polled regularly; after a stop, the mesh must not be used
///
/// Deterministic. O(points log points) for points that are spread evenly.
TetrahedronMesh volume_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop);

}  // namespace ccdt

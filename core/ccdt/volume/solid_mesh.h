// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "core/ccdt/volume/solid_domain.h"
#include "core/ccdt/volume/tetrahedron_mesh.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Triangulates points in a solid like volume_mesh() in a box, whose parameters are the same. The nearest points of the
/// surface to the first layer of points are vertices, too, unless they are close to each other, and so are points along
/// the creases of the surface. The mesh consists of the tetrahedra whose middle is inside, except for flat ones with
/// all corners on the surface.
/// @param spacing  of the points in the solid
///
/// Deterministic. O(n log n) for n = points + faces.
TetrahedronMesh volume_mesh(const SolidDomain& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop);

}  // namespace ccdt

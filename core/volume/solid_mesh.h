// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>

#include "core/geometry/point3.h"
#include "core/volume/solid_domain.h"
#include "core/volume/tetrahedron_mesh.h"
#include "core/volume/volume_spacing.h"

namespace ccdt {

/// Triangulates points in a solid, as in a box. Each point of the first layer has another vertex at the nearest point
/// of the surface. Creases of the surface have vertices, too. The mesh consists of the tetrahedra whose middle is
/// inside.
TetrahedronMesh volume_mesh(const SolidDomain& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop);

}  // namespace ccdt

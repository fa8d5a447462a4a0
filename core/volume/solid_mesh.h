// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/point3.h"
#include "core/volume/solid_domain.h"
#include "core/volume/tetrahedron_mesh.h"
#include "core/volume/volume_spacing.h"

namespace ccdt {

/// Triangulates points in a solid.
TetrahedronMesh volume_mesh(const SolidDomain& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            const std::stop_token& stop);

}  // namespace ccdt

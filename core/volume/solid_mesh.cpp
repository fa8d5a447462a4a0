// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/solid_mesh.h"

namespace ccdt {

TetrahedronMesh volume_mesh(const SolidDomain&, const VolumeSpacing&, std::span<const Point3> points,
                            const std::stop_token& stop) {
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    mesh.tetrahedra = delaunay_tetrahedra(points, stop);
    return mesh;
}

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/delaunay3.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Tetrahedra that fill a domain. On a torus, corners of a tetrahedron may belong to neighbouring periodic copies.
struct TetrahedronMesh {
    std::vector<Point3> vertices;  ///< points; in a box or solid, followed by the vertices on its surface
    std::vector<Tetrahedron> tetrahedra;
};

/// Thickness of the first layer of points off a border, in spacings. Its points get further vertices on the border.
inline constexpr double kFirstLayer = 0.75;

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Removes a site and inserts it in another triangle. Wherever the mesh was Delaunay around both positions, it is
/// Delaunay afterwards. Not for a torus; only after trim().
/// @param p  strictly inside the triangle
/// @returns  false, without moving the site, if no edge can be flipped away from the site because of its neighbours'
///           positions
bool relocate_site(Triangulation& mesh, std::uint32_t site, std::uint32_t triangle, Point p);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Removes a site and inserts it in another triangle. If the mesh was Delaunay around the old and the new position, it
/// is Delaunay there afterwards. Not for a torus; only after trim().
/// @param p  the new position, strictly inside `triangle`
/// @returns  false, without moving the site, if the positions of its neighbours do not allow the necessary flips
bool relocate_site(Triangulation& mesh, std::uint32_t site, std::uint32_t triangle, Point p);

}  // namespace ccdt

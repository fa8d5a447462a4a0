// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Returns the mesh of a domain's border, into which sites can be inserted. Marks the triangles outside the domain,
/// gives each sector of the inside its own vertices, and numbers the connected parts.
/// @param sites   number of sites to be inserted
/// @param border  triangulation of the border's vertices; its segments are the border itself, with the inside on their
///                left
Triangulation mesh_of_border(std::size_t sites, const ConstrainedDelaunay& border);

/// Returns the corners of the triangles in a part of the domain, or for kNone, in all parts. Only before trim().
std::vector<std::array<Point, 3>> inside_triangles(const Triangulation& mesh,
                                                   std::uint32_t part = Triangulation::kNone);

/// Drops triangles outside the domain and numbers the others in the order of the sites. Must follow all insertions.
void trim(Triangulation& mesh);

}  // namespace ccdt

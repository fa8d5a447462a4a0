// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Marks the triangles outside the domain, gives each sector of the inside its own vertices, and numbers the connected
/// parts. For a mesh of the border's vertices.
/// @param branches  as triangulate() returns them
void mark_inside(Triangulation& mesh, std::span<const ConstrainedDelaunay::Branch> branches);

/// Returns the corners of the triangles inside the domain, or inside one part of it. Only before trim().
std::vector<std::array<Point, 3>> inside_triangles(const Triangulation& mesh,
                                                   std::uint32_t part = Triangulation::kNone);

/// Drops triangles outside the domain and renumbers the others in the order of the sites. All sites must have been
/// inserted.
void trim(Triangulation& mesh);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>

#include "core/mesh/regions.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Flips edges until all edges that are not on the border are locally Delaunay, by exact predicates (Lawson's
/// algorithm). Every triangle must be counter-clockwise.
/// @param stop  polled regularly; a stop leaves a valid triangulation that is not Delaunay everywhere
/// @returns     the number of flips
std::size_t restore_delaunay(Triangulation& mesh, const std::stop_token& stop = {});

/// Flips the edges on a region's stack, and edges around them, until all are Delaunay. An edge is left for a larger
/// region, in Region::edges, if one of its two triangles has a vertex outside the region.
void legalise(Triangulation& mesh, Region& region);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// The constrained Delaunay triangulation of a domain's sites, with vertices along the border if there is one.
/// Capacities are measured on its triangles. All positions are in the unit frame.
struct DomainMesh {
    Border border;
    Triangulation mesh;
};

/// Triangulates the border alone, for sites to be inserted later.
/// @param border  border of the domain, which is not a torus
/// @param sites   number of sites to be inserted
/// @param stop    polled regularly; a stop gives the error Stopped
Result<DomainMesh> empty_mesh(const Domain& domain, Border border, std::size_t sites, const std::stop_token& stop = {});

/// Triangulates the border alone, for sites to be inserted later. Adds vertices along the border, as far apart as the
/// sites nearby will be. On a torus, the mesh has no border.
Result<DomainMesh> empty_mesh(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites,
                              const std::stop_token& stop = {});

/// Divides the sites among the connected parts of a domain, in proportion to the capacities of the parts. apportion()
/// makes the numbers whole.
/// @returns  number of sites of each part [parts of the mesh]; empty if the capacity is zero
std::vector<std::size_t> sites_of_parts(const DomainMesh& mesh, const CapacityIntegral& capacity);

/// Returns the positions of the sites in the caller's coordinates [sites].
std::vector<Point> sites_to_user(const Domain& domain, const Triangulation& mesh);

/// Copies a triangulation into the caller's coordinates.
/// @param mesh    trimmed
/// @param border  border of the mesh
TriangleMesh mesh_to_user(const Domain& domain, const Triangulation& mesh, const Border& border);

}  // namespace ccdt

#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/ccdt/border.h"
#include "core/ccdt/capacity_integral.h"
#include "core/ccdt/ccdt.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"
#include "core/result.h"

namespace ccdt {

/// Constrained Delaunay triangulation of a domain's sites, with vertices along its border, on a torus without. Its
/// triangles' capacities measure the sites. All places are in the unit frame.
struct DomainMesh {
    Border border;
    Triangulation mesh;
};

/// Triangulates the border alone, for sites to be inserted.
/// @param border  of the domain, which is no torus
/// @param sites   how many will be
/// @param stop    asked now and then: Error Stopped
Result<DomainMesh> empty_mesh(const Domain& domain, Border border, std::size_t sites, const std::stop_token& stop = {});

/// The same with the border that the capacity wants, or of a torus without any.
Result<DomainMesh> empty_mesh(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites,
                              const std::stop_token& stop = {});

/// Shares sites out among the connected parts of a domain by their capacity, whole numbers by the largest remainders
/// [parts of the mesh].
std::vector<std::size_t> sites_of_parts(const DomainMesh& mesh, const CapacityIntegral& capacity);

/// Places of the sites in the caller's coordinates [sites].
std::vector<Point> sites_to_user(const Domain& domain, const Triangulation& mesh);

/// Copies a triangulation into the caller's coordinates.
/// @param mesh    trimmed
/// @param border  of the mesh
TriangleMesh mesh_to_user(const Domain& domain, const Triangulation& mesh, const Border& border);

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/surface/triangle_soup.h"
#include "core/geometry/domain.h"

namespace ccdt::fuzz {

/// Checks the invariants of a domain: its rings, area and bounds.
void check_domain(const Domain& domain);

/// Checks that the arrays of a soup fit together, and that it has a colour everywhere if it has any.
void check_soup(const TriangleSoup& soup);

/// Checks at many positions whether they are inside the domain if and only if they are inside `parts`. Skips positions
/// that are closer to the border than rounding errors.
void check_cover(const Domain& domain, const std::vector<PolygonPart>& parts);

/// Checks that the part, ring and vertex named by an error or a repair exist in `parts`.
void check_location(const Error& error, const std::vector<PolygonPart>& parts);
void check_location(const Repair& repair, const std::vector<PolygonPart>& parts);

/// Checks that there are `sites` distinct points, all inside the domain.
///
/// @param parts  the polygons from which the domain was created; empty: only the bounds are checked
void check_points(const std::vector<Point>& points, std::size_t sites, const Domain& domain,
                  const std::vector<PolygonPart>& parts);

/// Distributes sites and checks the guarantees of distribute(): the number of points, all inside the domain, a mesh
/// that covers the domain, and the same result from a second run.
///
/// @param parts    as for check_points
/// @param options  should have few sites, to process many inputs; the mesh is always requested
void check_distribution(const Domain& domain, const std::vector<PolygonPart>& parts, const Density& density,
                        Options options);

}  // namespace ccdt::fuzz

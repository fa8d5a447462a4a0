// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::fuzz {

/// What Domain promises of its rings, areas and bounds.
void check_domain(const Domain& domain);

/// A domain covers what of its parts any of many probes is in, and nothing else, as far as rounding lets one tell.
void check_cover(const Domain& domain, const std::vector<PolygonPart>& parts);

/// The ring and vertex that an error of Domain::create points to are among those it was given.
void check_location(const Error& error, const std::vector<PolygonPart>& parts);
void check_location(const Repair& repair, const std::vector<PolygonPart>& parts);

/// So many points, all different, strictly inside the domain.
///
/// @param parts  what the domain was made of; none: a rectangle or a torus
void check_points(const std::vector<Point>& points, std::size_t sites, const Domain& domain,
                  const std::vector<PolygonPart>& parts);

/// Places sites and checks what distribute() promises: as many points, inside the domain, and a mesh that covers it.
///
/// @param parts    as above
/// @param options  for few sites, for inputs are many; the mesh is kept whatever they say
void check_distribution(const Domain& domain, const std::vector<PolygonPart>& parts, const Density& density,
                        Options options);

}  // namespace ccdt::fuzz

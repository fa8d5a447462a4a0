// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/relax/capacity_integral.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Evens out sites where the domain is narrower than their spacing. There, the sites form a row, in which triangles of
/// equal capacity do not fix the distances.
///
/// Divides the domain into triangles that are small compared with the spacing, and finds the connected sets of them
/// that are narrow. In each set with at least three sites, distributes the sites anew: first at equal steps of capacity
/// along a walk through the triangles, then by Lloyd's algorithm, with distances measured in capacities along the
/// triangles. So sites get about equal capacities, also at forks and in rings. The sites of a set stay where they are
/// if they would be considerably more crowded, by each other or by other sites, than before.
///
/// @param domain  not a torus
/// @param sites   in the unit frame; sites in narrow places move
/// @param site    capacity of a site
/// @param stop    polled regularly; after a stop the sites must not be used
/// @returns       whether each site moved [sites]; empty if none did
///
/// O(n log n) for n = sites + corners of the domain.
std::vector<std::uint8_t> even_out_narrow_places(const Domain& domain, const CapacityIntegral& capacity,
                                                 std::span<Point> sites, double site, const std::stop_token& stop);

}  // namespace ccdt

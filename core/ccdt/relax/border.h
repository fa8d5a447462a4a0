// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include <tl/expected.hpp>

#include "core/ccdt/relax/capacity_integral.h"
#include "core/geometry/delaunay.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Closed chains of vertices on the border. The triangulation needs these vertices; they are not part of the result.
struct Border {
    std::vector<std::vector<Point>> loops;  ///< with the inside on their left; corners of several loops may coincide
    /// [vertices of all loops in order] whether the vertex is a corner of the domain.
    std::vector<bool> corner;
};

/// Measures an edge in units of the local distance of neighbouring sites. Divides the edge into equal steps, and
/// returns the lengths from `begin` to the end of each step [steps + 1]; the first entry is 0.
using LengthInSites = std::function<std::vector<double>(Point begin, Point end)>;

/// Returns the domain's corners, and up to about `sites` vertices between them, as far apart as the sites nearby.
Border make_border(const Domain& domain, const LengthInSites& length, std::size_t sites);
Border make_border(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites);

/// Returns a border whose only vertices are the domain's corners.
Border bare_border(const Domain& domain);

/// Computes the constrained Delaunay triangulation of a border, without sites.
/// @param stop  polled regularly; after a stop the result must not be used
///
/// Fails if nearly touching edges touch or cross because vertices on edges are rounded. Never fails for a bare border.
tl::expected<ConstrainedDelaunay, SegmentConflict> triangulate(const Border& border, const std::stop_token& stop = {});

}  // namespace ccdt

#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include <tl/expected.hpp>

#include "core/ccdt/capacity_integral.h"
#include "core/geometry/delaunay.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Closed chains of vertices on the border, which the triangulation needs and the result does not hold.
struct Border {
    std::vector<std::vector<Point>> loops;  ///< the inside on their left; corners of several may be in one place
    std::vector<bool> corner;               ///< [vertices of all loops in turn]: a corner of the domain
};

/// Measures an edge in the distances that neighbouring sites have there: from its begin to each of some equal steps
/// [steps + 1], the first of which is 0.
using LengthInSites = std::function<std::vector<double>(Point begin, Point end)>;

/// The domain's corners and, between them, vertices about as far apart as sites are there. Their number without the
/// corners is at most about that of the sites.
Border make_border(const Domain& domain, const LengthInSites& length, std::size_t sites);
Border make_border(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites);

/// The domain's corners alone.
Border bare_border(const Domain& domain);

/// Constrained Delaunay triangulation of a border, without sites.
/// @param stop  asked now and then; what is returned is of no use, then
/// Fails where vertices set on edges round off them, and the edges, almost touching, cross or touch; never for a bare
/// border.
tl::expected<ConstrainedDelaunay, SegmentConflict> triangulate(const Border& border, const std::stop_token& stop = {});

}  // namespace ccdt

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include <tl/expected.hpp>

#include "core/geometry/point.h"

// Delaunay triangulation and exact predicates by CGAL; only delaunay.cpp includes it.
namespace ccdt {

/// A segment between two points, by their indices.
using Segment = std::array<std::uint32_t, 2>;

/// Triangulation of a box around the points it was made of. Edges of triangle t run from corners[i] to
/// corners[(i + 1) % 3].
struct ConstrainedDelaunay {
    struct Triangle {
        std::array<std::uint32_t, 3> corners;     ///< counter-clockwise
        std::array<std::uint32_t, 3> neighbours;  ///< across each edge; kNone at the box
        std::array<bool, 3> constrained;          ///< the edge is one of the segments
    };
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    std::vector<Point> points;  ///< those given, then the four corners of the box
    std::vector<Triangle> triangles;
};

/// A segment that meets another one, or a point, elsewhere than at its ends, or whose ends coincide with other points.
struct SegmentConflict {
    std::size_t segment = 0;
};

/// Delaunay triangulation in which every segment is an edge.
///
/// @param points    finite, within [0, 1] x [0, 1]
/// @param segments  distinct, none of zero length
/// @param stop      asked now and then; what is returned is of no use, then
/// The box has a margin of 1 about the unit square: collinear points are then no special case.
/// O(n log n) for all inputs that people draw.
tl::expected<ConstrainedDelaunay, SegmentConflict> constrained_delaunay(std::span<const Point> points,
                                                                        std::span<const Segment> segments,
                                                                        const std::stop_token& stop = {});

/// Sign of the doubled area of triangle abc: 1 if it runs counter-clockwise, 0 if collinear. Exact.
int exact_orientation(Point a, Point b, Point c);

/// 1 if d lies inside the circle through the counter-clockwise triangle abc, 0 if on it, else -1. Exact.
int exact_in_circle(Point a, Point b, Point c, Point d);

}  // namespace ccdt

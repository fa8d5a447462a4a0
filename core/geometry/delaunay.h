// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include <tl/expected.hpp>

#include "core/geometry/point.h"

// Delaunay triangulation and exact predicates by CGAL, which only delaunay.cpp includes.
namespace ccdt {

/// A segment between two points, given by their indices.
using Segment = std::array<std::uint32_t, 2>;

/// A triangulation of a box around the input points. Edge i of a triangle runs from corners[i] to corners[(i + 1) % 3].
struct ConstrainedDelaunay {
    struct Triangle {
        std::array<std::uint32_t, 3> corners;     ///< counter-clockwise
        std::array<std::uint32_t, 3> neighbours;  ///< [edges] triangle across edge i; kNone: outside the box
        std::array<bool, 3> constrained;          ///< [edges] whether edge i is one of the segments
    };
    /// A segment that begins at one of several coincident points.
    struct Branch {
        Segment vertices;     ///< the two vertices of the segment
        std::uint32_t point;  ///< the input point at which the segment begins
    };
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    std::vector<Point> points;  ///< the input points, then the four corners of the box
    std::vector<Triangle> triangles;
    /// [input points] vertex of each; coincident points share a vertex, which has the number of one of them.
    std::vector<std::uint32_t> vertex_of;
    std::vector<Branch> branches;  ///< sorted by `vertices`
};

/// A segment that meets another segment, or a point, other than at its ends.
struct SegmentConflict {
    std::size_t segment = 0;
};

/// Computes a Delaunay triangulation in which every segment is an edge.
///
/// @param points    finite, within [0, 1] x [0, 1]; coincident points share a vertex
/// @param segments  distinct, none of zero length
/// @param stop      polled regularly; after a stop the result must not be used
///
/// The box has a margin of 1 around the unit square, so that collinear points are no special case.
/// O(n log n) for inputs that occur in practice.
tl::expected<ConstrainedDelaunay, SegmentConflict> constrained_delaunay(std::span<const Point> points,
                                                                        std::span<const Segment> segments,
                                                                        const std::stop_token& stop = {});

/// Closed chains of segments. Each point is joined to the next point of its chain. Several chains can form a group.
struct Chains {
    std::vector<Point> points;  ///< within [0, 1] x [0, 1]; each coordinate is 0 or at least kMinCoordinate
    /// [points] end point of the segment that begins at this point; the point itself if no segment begins there.
    std::vector<std::uint32_t> next;
    std::vector<std::uint32_t> group;  ///< [points] the group of the chain, below `groups`
    std::uint32_t groups = 0;
};

/// A triangulation of a box around chains, which may cross, touch and overlap. Edge numbers: see ConstrainedDelaunay.
struct Arrangement {
    struct Triangle {
        std::array<std::uint32_t, 3> corners;     ///< counter-clockwise
        std::array<std::uint32_t, 3> neighbours;  ///< [edges] triangle across edge i; kNone: outside the box
        std::array<std::uint32_t, 3> sets;  ///< [edges] number of the set of groups along edge i; kNone: no segment
    };
    /// A point where a segment meets another segment other than at a shared end.
    struct Meeting {
        enum class Kind { Touch, Overlap, Cross };
        Kind kind;
        std::uint32_t segment;  ///< identified by the point at which it begins
        std::uint32_t vertex;   ///< the vertex that the segment touches; kNone if it meets an edge
        /// A group along the edge that the segment meets, preferably the segment's own; kNone if it meets a vertex.
        std::uint32_t group;
        Point position;
    };
    static constexpr std::uint32_t kNone = ConstrainedDelaunay::kNone;

    std::vector<Point> points;  ///< the input points, the four corners of the box, then the crossings
    std::vector<Triangle> triangles;
    /// [input points] vertex of each; coincident points share a vertex, which has the number of one of them.
    std::vector<std::uint32_t> vertex_of;
    std::vector<Meeting> meetings;

    /// Returns the groups of a set (see Triangle::sets) in ascending order. These are the groups that have an odd
    /// number of segments along each edge with this set.
    std::span<const std::uint32_t> groups_of(std::uint32_t set) const {
        return {members.data() + begins[set], members.data() + begins[set + 1]};
    }
    std::vector<std::uint32_t> members;
    std::vector<std::uint32_t> begins;  ///< [sets + 1] offsets into `members`; set g < groups holds group g alone
};

/// The error of too many crossings, with the segment at which the limit was exceeded.
struct TooManyCrossings {
    std::uint32_t segment = 0;  ///< identified by the point at which it begins
    Point position;
};

/// Computes a triangulation in which every segment is a chain of edges, cut wherever it meets another segment. The
/// triangulation is Delaunay unless there are very many segments.
///
/// @param tolerance  a segment that crosses another one but ends within this distance of it counts as touching it
/// @param most       limit on the number of pieces that crossings create
/// @param stop       polled regularly; after a stop the result must not be used
///
/// Each crossing becomes a vertex at the exact intersection, rounded. Because of the rounding, a piece can cross
/// further pieces; these crossings are cut in the same way. So no two edges cross, and all chains remain closed.
/// Therefore the number of segments crossed on the way to a triangle tells whether it lies inside a chain. Each cut
/// moves a piece by at most a rounding error. Nothing else moves.
///
/// Deterministic. O(n log n) for inputs that occur in practice, plus some microseconds for each crossing.
tl::expected<Arrangement, TooManyCrossings> arrange(const Chains& chains, double tolerance, std::size_t most,
                                                    const std::stop_token& stop = {});

/// Returns the sign of the signed area of triangle abc: 1 if counter-clockwise, 0 if collinear, -1 if clockwise. Exact.
int exact_orientation(Point a, Point b, Point c);

/// Returns the ordinate of the segment ab at abscissa x, which lies between the differing abscissas of a and b. The
/// result is exact except for one final rounding.
double exact_ordinate(Point a, Point b, double x);

/// Returns 1 if d lies inside the circle through the counter-clockwise triangle abc, 0 if on it, -1 if outside. Exact.
int exact_in_circle(Point a, Point b, Point c, Point d);

}  // namespace ccdt

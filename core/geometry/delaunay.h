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
    /// A segment that begins at one of several points in one place.
    struct Branch {
        Segment vertices;     ///< that it runs between
        std::uint32_t point;  ///< that it begins at
    };
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    std::vector<Point> points;  ///< those given, then the four corners of the box
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> vertex_of;  ///< [given points] itself; of several in one place the same one
    std::vector<Branch> branches;          ///< in the order of their vertices
};

/// A segment that meets another one, or a point, elsewhere than at its ends.
struct SegmentConflict {
    std::size_t segment = 0;
};

/// Delaunay triangulation in which every segment is an edge.
///
/// @param points    finite, within [0, 1] x [0, 1]; those in one place are one vertex
/// @param segments  distinct, none of zero length
/// @param stop      asked now and then; what is returned is of no use, then
/// The box has a margin of 1 about the unit square: collinear points are then no special case.
/// O(n log n) for all inputs that people draw.
tl::expected<ConstrainedDelaunay, SegmentConflict> constrained_delaunay(std::span<const Point> points,
                                                                        std::span<const Segment> segments,
                                                                        const std::stop_token& stop = {});

/// Points, each with a segment to the next one of its chain. Chains are closed; several may make a group.
struct Chains {
    std::vector<Point> points;         ///< within [0, 1] x [0, 1], coordinates 0 or at least kLeastCoordinate
    std::vector<std::uint32_t> next;   ///< [points] where the segment that begins here ends; nowhere near means itself
    std::vector<std::uint32_t> group;  ///< [points] which the chain belongs to, below `groups`
    std::uint32_t groups = 0;
};

/// Triangulation of a box around chains, which may meet as they like. Edges of triangle t run as above.
struct Arrangement {
    struct Triangle {
        std::array<std::uint32_t, 3> corners;     ///< counter-clockwise
        std::array<std::uint32_t, 3> neighbours;  ///< across each edge; kNone at the box
        std::array<std::uint32_t, 3> sets;        ///< of groups, along each edge; kNone: no segment runs there
    };
    /// Where a segment meets another one elsewhere than at an end they share.
    struct Meeting {
        enum class Kind { Touch, Overlap, Cross };
        Kind kind;
        std::uint32_t segment;  ///< by the point that it begins at
        std::uint32_t vertex;   ///< that it touches; kNone: it meets an edge
        std::uint32_t group;    ///< of that edge, the segment's own if it is among them; kNone for a vertex
        Point place;
    };
    static constexpr std::uint32_t kNone = ConstrainedDelaunay::kNone;

    std::vector<Point> points;  ///< those given, the four corners of the box, then where segments cross
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> vertex_of;  ///< [given points] itself; of several in one place the same one
    std::vector<Meeting> meetings;

    /// Groups of which an odd number of segments runs along an edge, in order.
    std::span<const std::uint32_t> groups_of(std::uint32_t set) const {
        return {members.data() + begins[set], members.data() + begins[set + 1]};
    }
    std::vector<std::uint32_t> members;
    std::vector<std::uint32_t> begins;  ///< into `members` [sets + 1]; set g, of the first sets, is group g alone
};

/// Segments cross too often: the one at which it was enough.
struct TooManyCrossings {
    std::uint32_t segment = 0;  ///< by the point that it begins at
    Point place;
};

/// Delaunay triangulation in which every segment is a chain of edges, cut wherever it meets another one.
///
/// @param tolerance  a segment that crosses another one, but ends as near to it as this, touches it
/// @param most       pieces that crossings may make
/// @param stop       asked now and then; what is returned is of no use, then
/// Where segments cross there is a new vertex: the exact place, rounded. Pieces that this bends across others are cut
/// again, so that edges do not cross and all chains are closed still: on which side of a chain a triangle lies is a
/// matter of counting edges. A piece is moved by a rounding error at each cut and nothing else is moved at all.
/// Same input, same output. O(n log n) for all inputs that people draw, and some microseconds for each crossing.
tl::expected<Arrangement, TooManyCrossings> arrange(const Chains& chains, double tolerance, std::size_t most,
                                                    const std::stop_token& stop = {});

/// Sign of the doubled area of triangle abc: 1 if it runs counter-clockwise, 0 if collinear. Exact.
int exact_orientation(Point a, Point b, Point c);

/// The ordinate of a segment at an abscissa that lies between those of its ends, which differ; exact, but for one
/// rounding.
double exact_ordinate(Point a, Point b, double x);

/// 1 if d lies inside the circle through the counter-clockwise triangle abc, 0 if on it, else -1. Exact.
int exact_in_circle(Point a, Point b, Point c, Point d);

}  // namespace ccdt

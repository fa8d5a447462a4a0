#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt {

/// Corners of a closed chain of segments; the last one is joined to the first.
using Ring = std::vector<Point>;

/// A part of a domain as callers give it: rings open or closed (first corner repeated), any orientation.
struct PolygonPart {
    Ring outer;
    std::vector<Ring> holes;
};

/// A bounded region of the plane, disjoint simple polygons with holes, or a torus. Valid by construction.
///
/// Kept normalised: `rings()` are in the unit frame, where the longer side of the bounding box is 1 and its
/// lower left corner the origin; repeated corners are dropped, outer rings run counter-clockwise, holes
/// clockwise. `to_user` takes a point of the unit frame back to the caller's coordinates.
///
/// Whoever computes with a domain may rely on it: in the caller's coordinates the longer side is 1e-140 to 1e140 and no
/// coordinate more than 1e9 times that; the shorter side is at least 1e-12 times the longer, the area 1e-12 times its
/// square. So quotients of sides, and products of two lengths with whatever counts sites or cells, are finite and
/// not 0. Coordinates of corners in the unit frame are 0 or at least kLeast, so that slopes of edges are finite.
class Domain {
public:
    /// Distance in the unit frame below which a corner counts as on the lower or the left side of the bounding box: far
    /// less than points are told apart by.
    static constexpr double kLeast = 0x1p-100;

    /// @param parts  at least one; a part may lie inside a hole of another
    /// @param stop   asked now and then: Error Stopped
    /// Errors (Unusable): fewer than three distinct corners, a coordinate that is not finite, an extent out of range,
    /// zero area, crossing, touching or overlapping rings, a hole outside its part, a hole in a hole. The message names
    /// the ring and the vertex; `field` is their JSON Pointer below the polygon, as GeoJSON's MultiPolygon nests them:
    /// /part/ring/vertex, ring 0 being the outer one and vertices as the caller counts them.
    static Result<Domain> create(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// Rectangle [0, width] x [0, height].
    static Result<Domain> rectangle(double width, double height);

    /// Torus [0, width) x [0, height), opposite sides joined: a set of points on it tiles the plane.
    /// Errors (Unusable): a side that is not finite and positive, sides further apart than 1 to 1000.
    static Result<Domain> torus(double width, double height);

    /// Outer rings and holes in the unit frame; none of a torus, which has no border.
    const std::vector<Ring>& rings() const { return rings_; }

    /// Bounding box in the unit frame; its min is the origin.
    Box unit_bounds() const { return {{0, 0}, unit_size_}; }

    /// Bounding box in the caller's coordinates.
    const Box& bounds() const { return bounds_; }

    /// Area in the caller's coordinates.
    double area() const;

    /// Area in the unit frame.
    double unit_area() const { return unit_area_; }

    std::size_t corner_count() const;

    /// Tells whether the domain is its own bounding box. So is a torus.
    bool is_box() const { return is_box_; }

    /// Opposite sides of the bounding box are joined. Its unit frame's sides are multiples of 2^-50.
    bool is_torus() const { return is_torus_; }

    /// Converts a point of the unit frame to the caller's coordinates. On a torus it may be any copy: the one in [0,
    /// width) x [0, height) is returned.
    Point to_user(Point unit) const;

    /// Distance by which to_user() may move a point by rounding, in the unit frame.
    double resolution() const;

private:
    Domain() = default;

    std::vector<Ring> rings_;
    Box bounds_;
    Point unit_size_;
    double scale_ = 1;  ///< caller's units per unit of the unit frame
    double unit_area_ = 0;
    bool is_box_ = false;
    bool is_torus_ = false;
};

}  // namespace ccdt

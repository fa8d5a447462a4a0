#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/faults.h"
#include "core/geometry/point.h"
#include "core/geometry/polygon.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"
#include "core/result.h"

namespace ccdt {

struct RepairedDomain;
struct RepairedArea;

/// A bounded region of the plane, polygons with holes, or a torus. Valid by construction.
///
/// Kept normalised: `rings()` are in the unit frame, where the longer side of the bounding box is 1 and its lower left
/// corner the origin; no corner repeats the one before, and the inside is on the left, so that outer rings run
/// counter-clockwise and holes clockwise. Rings do not cross; they may touch, themselves and each other, but at corners
/// only, and edges do not. Where the inside has several fans of triangles in one place, each has a corner there of its
/// own, whose two edges are the sides of the fan. `to_user` takes a point of the unit frame back to the caller's
/// coordinates.
///
/// Whoever computes with a domain may rely on it: in the caller's coordinates the longer side is 1e-140 to 1e140 and no
/// coordinate more than 1e9 times that; the shorter side is at least 1e-12 times the longer, the area 1e-12 times its
/// square. So quotients of sides, and products of two lengths with whatever counts sites or cells, are finite and
/// not 0. Coordinates of corners in the unit frame are 0 or at least kLeast, so that slopes of edges are finite.
class Domain {
public:
    /// Distance in the unit frame below which a corner counts as on the lower or the left side of the bounding box: far
    /// less than points are told apart by.
    static constexpr double kLeast = kLeastCoordinate;

    /// @param parts  at least one; a part may lie inside a hole of another. Rings and parts may touch at points.
    /// @param stop   asked now and then: Error Stopped
    /// Errors (Unusable): a coordinate that is not finite, an extent out of range, no area; what is not valid by OGC
    /// Simple Features: rings without area, that cross or touch themselves, that cross, overlap or run along others; a
    /// hole outside its part, a hole in a hole, an inside that is cut into pieces. The message names the ring and the
    /// place; `field` is the JSON Pointer below the polygon, as GeoJSON's MultiPolygon nests them: /part/ring/vertex,
    /// ring 0 being the outer one and vertices as the caller counts them.
    static Result<Domain> create(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// The same, but what is not valid is put right: of each ring what is inside by the even-odd rule, of each part the
    /// outer ring's area without the holes', and all parts together.
    /// Errors (Unusable): a coordinate that is not finite, an extent out of range, no area in all, rings that cross too
    /// often.
    static Result<RepairedDomain> repair(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// The area that closed chains of segments, of any number and order, enclose all together by the even-odd rule;
    /// what runs there and back encloses nothing. Errors: as repair().
    static Result<Domain> enclosed_by(const std::vector<Ring>& rings, const std::stop_token& stop = {});

    /// What a domain made by repair() would enclose, of whatever extent, be it too little for a domain.
    /// Errors: as repair(), but for those of an extent.
    static Result<RepairedArea> repair_area(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// The area that any of several domains covers, none of them a torus; they may touch, overlap, and have edges in
    /// common. Errors: as repair().
    /// @param domains  at least one
    static Result<Domain> united(std::span<const Domain* const> domains, const std::stop_token& stop = {});

    /// Rectangle [0, width] x [0, height].
    static Result<Domain> rectangle(double width, double height);

    /// Torus [0, width) x [0, height), opposite sides joined: a set of points on it tiles the plane.
    /// Errors (Unusable): a side that is not finite and positive, sides further apart than 1 to 1000.
    static Result<Domain> torus(double width, double height);

    /// What is left of the domain without areas. The unit frame and the bounding box stay what they are.
    /// @param areas  in the unit frame, within the bounding box
    /// Not of a torus. Errors (Unusable): nothing is left; areas that cross too often.
    Result<Domain> without(std::span<const Area> areas, const std::stop_token& stop = {}) const;

    /// What rings enclose within the domain. The unit frame and the bounding box stay what they are.
    /// @param rings  valid, the inside on their left, in the unit frame
    /// Errors (Unusable): nothing is left.
    Result<Domain> within(std::vector<Ring> rings) const;

    /// Outer rings and holes in the unit frame; none of a torus, which has no border.
    const std::vector<Ring>& rings() const { return rings_; }

    /// Bounding box in the unit frame; its min is the origin.
    Box unit_bounds() const { return {{0, 0}, unit_size_}; }

    /// Bounding box in the caller's coordinates.
    const Box& bounds() const { return frame_.bounds; }

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

    /// Converts a point of the caller's coordinates to the unit frame; on a torus, to its copy in the box.
    Point to_unit(Point user) const;

    /// Distance by which to_user() may move a point by rounding, in the unit frame.
    double resolution() const { return frame_.resolution(); }

private:
    Domain() = default;

    /// Takes rings that are valid, and checks that they are of use.
    static Result<Domain> make(std::vector<Ring> rings, const UnitFrame& frame, const std::vector<RingInput>& given);

    std::vector<Ring> rings_;
    UnitFrame frame_;
    Point unit_size_;
    double unit_area_ = 0;
    bool is_box_ = false;
    bool is_torus_ = false;
};

/// An area in the caller's coordinates, and what was wrong with the polygon that it was made of.
struct RepairedArea {
    Area rings;
    std::vector<Repair> repairs;  ///< in the order of the rings
};

/// A domain, and what was wrong with the polygon that it was made of.
struct RepairedDomain {
    Domain domain;
    std::vector<Repair> repairs;  ///< in the order of the rings
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/faults.h"
#include "core/geometry/point.h"
#include "core/geometry/polygon.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"

namespace ccdt {

struct RepairedDomain;
struct RepairedArea;

/// A bounded region of the plane (polygons with holes) or a torus. Valid by construction.
///
/// Rings are kept normalised, in the unit frame: the longer side of the bounding box is 1 and its lower left corner is
/// the origin. Successive corners differ. The inside lies on the left, so outer rings run counter-clockwise and holes
/// clockwise. Rings do not cross. They may touch themselves and each other, but only at corners. Where several separate
/// sectors of the inside meet at one point, each sector has its own corner there, between the two edges that bound the
/// sector. `to_user` converts a point of the unit frame to the caller's coordinates.
///
/// Guaranteed ranges, in the caller's coordinates: the longer side is between 1e-140 and 1e140, and no coordinate
/// exceeds 1e9 times the longer side. The shorter side is at least 1e-12 times the longer side, and the area at least
/// 1e-12 times its square. So quotients of sides, and products of two lengths with any count of sites or cells, are
/// finite and not 0. Coordinates of corners in the unit frame are 0 or at least kMin, so slopes of edges are finite.
class Domain {
public:
    /// Distance in the unit frame below which a corner counts as lying on the left or lower side of the bounding box.
    /// This distance is far below the resolution of points.
    static constexpr double kMin = kMinCoordinate;

    /// Creates a domain from polygons.
    ///
    /// @param parts  at least one; a part may lie inside a hole of another one. Rings and parts may touch at points.
    /// @param stop   polled regularly; a stop gives the error Stopped
    ///
    /// Errors (Unusable): a coordinate that is not finite; an extent out of range; no area; anything that OGC Simple
    /// Features does not allow: rings without area, rings that cross or touch themselves, rings that cross, overlap or
    /// share edges, a hole outside its part, a hole in a hole, a disconnected inside.
    ///
    /// The message names the ring and the position. `field` is a JSON Pointer relative to the polygon, nested as in
    /// GeoJSON's MultiPolygon: /part/ring/vertex, with ring 0 the outer one and the caller's vertex numbers.
    static Result<Domain> create(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// Creates a domain and repairs invalid input. A ring encloses its inside by the even-odd rule, a part is its outer
    /// ring minus its holes, and the domain is the union of all parts.
    /// Errors (Unusable): a coordinate that is not finite; an extent out of range; no area at all; rings that cross too
    /// often.
    static Result<RepairedDomain> repair(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// Creates the domain that closed chains of segments together enclose by the even-odd rule. Segments that run back
    /// and forth along the same line enclose nothing. Errors: as repair().
    static Result<Domain> enclosed_by(const std::vector<Ring>& rings, const std::stop_token& stop = {});

    /// Computes the area that a domain made by repair() would enclose. The extent of the area may be out of range for a
    /// domain. Errors: as repair(), except for errors about the extent.
    static Result<RepairedArea> repair_area(const std::vector<PolygonPart>& parts, const std::stop_token& stop = {});

    /// Creates the union of domains (no tori), which may touch, overlap and share edges. Errors: as repair().
    /// @param domains  at least one
    static Result<Domain> united(std::span<const Domain* const> domains, const std::stop_token& stop = {});

    /// Returns the rectangle [0, width] x [0, height].
    static Result<Domain> rectangle(double width, double height);

    /// Returns the torus [0, width) x [0, height) with opposite sides joined, so that copies of a pattern on it tile
    /// the plane. Errors (Unusable): a side that is not finite and positive; an aspect ratio above 1000.
    static Result<Domain> torus(double width, double height);

    /// Subtracts areas. The unit frame and the bounding box do not change. The domain must not be a torus.
    /// @param areas  in the unit frame, within the bounding box
    ///
    /// Errors (Unusable): nothing is left; the areas cross too often.
    Result<Domain> without(std::span<const Area> areas, const std::stop_token& stop = {}) const;

    /// Returns the domain enclosed by rings within this domain. The unit frame and the bounding box do not change.
    /// @param rings  valid, in the unit frame, with the inside on their left
    ///
    /// Errors (Unusable): nothing is left.
    Result<Domain> within(std::vector<Ring> rings) const;

    /// Returns the outer rings and holes in the unit frame; empty for a torus, which has no border.
    const std::vector<Ring>& rings() const { return rings_; }

    /// Returns the bounding box in the unit frame; its min is the origin.
    Box unit_bounds() const { return {{0, 0}, unit_size_}; }

    /// Returns the bounding box in the caller's coordinates.
    const Box& bounds() const { return frame_.bounds; }

    /// Returns the area in the caller's coordinates.
    double area() const;

    /// Returns the area in the unit frame.
    double unit_area() const { return unit_area_; }

    std::size_t corner_count() const;

    /// Whether the domain equals its bounding box, as a torus does.
    bool is_box() const { return is_box_; }

    /// Whether opposite sides of the box are joined. In the unit frame, the sides of a torus are multiples of 2^-50.
    bool is_torus() const { return is_torus_; }

    /// Converts a point of the unit frame to the caller's coordinates. On a torus any periodic copy is accepted, and
    /// the result is the copy in [0, width) x [0, height).
    Point to_user(Point unit) const;

    /// Converts a point from the caller's coordinates to the unit frame; on a torus, to its copy in the box.
    Point to_unit(Point user) const;

    /// Returns the largest distance in the unit frame by which rounding in to_user() moves a point.
    double resolution() const { return frame_.resolution(); }

private:
    Domain() = default;

    /// Checks that valid rings have enough area for a domain, and builds the domain.
    /// @param given  the caller's rings, for error messages
    static Result<Domain> make(std::vector<Ring> rings, const UnitFrame& frame, const std::vector<RingInput>& given);

    std::vector<Ring> rings_;
    UnitFrame frame_;
    Point unit_size_;
    double unit_area_ = 0;
    bool is_box_ = false;
    bool is_torus_ = false;
};

/// An area in the caller's coordinates, and the repairs made to the polygon that defines it.
struct RepairedArea {
    Area rings;
    std::vector<Repair> repairs;  ///< in the order of the rings
};

/// A domain, and the repairs made to the polygon that defines it.
struct RepairedDomain {
    Domain domain;
    std::vector<Repair> repairs;  ///< in the order of the rings
};

}  // namespace ccdt

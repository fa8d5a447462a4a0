// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <unordered_set>
#include <utility>

#include "core/ccdt/globe/map_projection.h"
#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Receives lines corner by corner. `begins` is true for the first corner of a line.
using LineSink = std::function<void(Point corner, bool begins)>;

/// Traces the borders of the features of a map as lines. An edge that several features share is traced once, if its
/// ends are equal. On the globe, edges along the antimeridian that lie on both sides of it, and edges along a pole, are
/// no borders: files divide areas there.
class Outlines {
public:
    /// @param projection  null: coordinates are those of a plane. Must outlive this object
    /// @param tolerance   corners that are closer than this to the corner before are left out; in the plane of lines
    Outlines(const MapProjection* projection, double tolerance) : projection_(projection), tolerance_(tolerance) {}

    /// Traces the borders of a feature, except for edges that have already been traced. O(corners).
    /// @param feature  on the globe, results of unrolled()
    void trace(std::span<const PolygonPart> feature, const LineSink& sink);

private:
    /// An edge in either direction: the end from which it runs to the east, within one turn, and the way to the other.
    using Edge = std::pair<Point, Point>;
    struct Hash {
        std::size_t operator()(const Edge& edge) const;
    };

    Edge edge_between(Point a, Point b) const;
    std::unordered_set<Edge, Hash> find_cuts(std::span<const PolygonPart> feature) const;
    void trace(const Ring& ring, const LineSink& sink);
    void move_to(Point corner, const LineSink& sink);
    void line_to(Point corner, const LineSink& sink);
    void lift(const LineSink& sink);

    const MapProjection* projection_;
    double tolerance_;
    std::unordered_set<Edge, Hash> traced_;
    bool is_drawing_ = false;
    Point last_{}, skipped_{};  ///< the last corner of the line, and the last one that was left out
    bool is_skipped_ = false;
};

}  // namespace ccdt

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/difference.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/delaunay.h"

namespace ccdt {

namespace {

/// The line along a side of a box.
struct Side {
    bool is_upright = false;
    double at = 0;
    double inwards = 1;  ///< 1 if the box lies on the right of the side or above it, else -1
};

Point turned(Point p) {
    return {p.y, p.x};
}

/// Returns the point where an edge crosses the line of a side.
Point crossing(const Side& side, Point a, Point b) {
    if (side.is_upright) return {side.at, exact_ordinate(a, b, side.at)};
    return {exact_ordinate(turned(a), turned(b), side.at), side.at};
}

/// Clips a ring to one side of a line. Where the ring is cut off, the result has edges along that line.
/// Source: Sutherland and Hodgman, Reentrant polygon clipping, CACM 17 (1974).
Ring clipped(const Ring& ring, const Side& side) {
    Ring kept;
    const auto depth = [&](Point p) { return side.inwards * ((side.is_upright ? p.x : p.y) - side.at); };
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        const double from = depth(a), to = depth(b);
        if (from >= 0) kept.push_back(a);
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) kept.push_back(crossing(side, a, b));
    }
    return kept;
}

/// Whether the bounding box of a ring meets a box.
bool may_meet(const Ring& ring, const Box& box) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Box own{{kFar, kFar}, {-kFar, -kFar}};
    for (const Point& p : ring) own.include(p);
    return own.min.x <= box.max.x && own.max.x >= box.min.x && own.min.y <= box.max.y && own.max.y >= box.min.y;
}

}  // namespace

Ring clipped(Ring ring, const Box& box) {
    for (const Side& side :
         {Side{true, box.min.x, 1}, Side{true, box.max.x, -1}, Side{false, box.min.y, 1}, Side{false, box.max.y, -1}}) {
        ring = clipped(ring, side);
    }
    return ring;
}

Area outside_of(const Domain& domain, const Box& box) {
    Box all = domain.bounds();
    all.include(box.min);
    all.include(box.max);
    const double beyond = std::max(all.width(), all.height());
    const Point low = all.min - Point{beyond, beyond}, high = all.max + Point{beyond, beyond};
    Area area = {{low, {high.x, low.y}, high, {low.x, high.y}}};
    for (Ring ring : domain.rings()) {
        for (Point& p : ring) p = domain.to_user(p);
        area.push_back(std::move(ring));
    }
    return area;
}

Result<Domain> without(const Domain& domain, std::span<const Area> areas, const std::stop_token& stop) {
    std::vector<Area> inside;
    for (const Area& area : areas) {
        Area rings;
        for (const Ring& given : area) {
            if (!may_meet(given, domain.bounds())) continue;
            Ring& ring = rings.emplace_back(clipped(given, domain.bounds()));
            for (Point& p : ring) p = domain.to_unit(p);
            if (ring.size() < 3) rings.pop_back();
        }
        if (!rings.empty()) inside.push_back(std::move(rings));
    }
    if (inside.empty()) return domain;
    return domain.without(inside, stop);
}

}  // namespace ccdt

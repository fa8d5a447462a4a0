#include "core/geometry/difference.h"

#include <utility>
#include <vector>

#include "core/geometry/delaunay.h"

namespace ccdt {

namespace {

/// A side of a box.
struct Side {
    bool is_upright = false;
    double at = 0;
    double inwards = 1;  ///< 1: the box lies on the right of it, or above; -1: on the other side
};

Point turned(Point p) {
    return {p.y, p.x};
}

/// Where an edge crosses the line of a side.
Point crossing(const Side& side, Point a, Point b) {
    if (side.is_upright) return {side.at, exact_ordinate(a, b, side.at)};
    return {exact_ordinate(turned(a), turned(b), side.at), side.at};
}

/// The part of a ring within the line of a side, with edges along it.
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

}  // namespace

Ring clipped(Ring ring, const Box& box) {
    for (const Side& side :
         {Side{true, box.min.x, 1}, Side{true, box.max.x, -1}, Side{false, box.min.y, 1}, Side{false, box.max.y, -1}}) {
        ring = clipped(ring, side);
    }
    return ring;
}

Result<Domain> without(const Domain& domain, std::span<const Area> areas, const std::stop_token& stop) {
    std::vector<Area> inside;
    for (const Area& area : areas) {
        Area rings;
        for (const Ring& given : area) {
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

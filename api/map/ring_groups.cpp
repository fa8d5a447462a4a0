// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/ring_groups.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/elementary.h"
#include "core/geometry/point.h"

namespace ccdt::api {
namespace {

/// Returns the power of two by which all coordinates must be multiplied to lie in [-1, 1], so that products of them are
/// finite.
double scale_of(std::span<const Ring> rings) {
    double largest = 0;
    for (const Ring& ring : rings) {
        for (const Point& p : ring) largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
    }
    constexpr int kMaxExponent = 1023;
    return largest > 0 ? elementary::exp2(-std::clamp(std::ilogb(largest) + 1, -kMaxExponent, kMaxExponent)) : 1;
}

/// Edge of an outer ring, from its lower to its upper end.
struct Edge {
    Point low, high;
    std::size_t ring = 0;

    /// Whether the edge passes a point on its left. The point is not below the lower end, but below the upper end.
    bool is_left_of(Point p) const { return cross(high - low, p - low) < 0; }
};

/// Returns the abscissas at which a ring crosses a horizontal line.
std::vector<double> crossings(const Ring& ring, double y, double scale) {
    std::vector<double> xs;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = scale * ring[i], b = scale * ring[(i + 1) % ring.size()];
        if ((a.y <= y) != (b.y <= y)) xs.push_back(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
    }
    std::ranges::sort(xs);
    return xs;
}

/// Finds a point inside a ring that is far from its corners: the middle of the widest part of the ring on a horizontal
/// line through the middle of the largest gap between the ordinates of corners.
Point inner_point(const Ring& ring, double scale) {
    std::vector<double> ys;
    for (const Point& p : ring) ys.push_back(p.y * scale);
    std::ranges::sort(ys);
    std::size_t widest = 1;
    for (std::size_t i = 1; i < ys.size(); ++i) {
        if (ys[i] - ys[i - 1] > ys[widest] - ys[widest - 1]) widest = i;
    }
    const double y = (ys[widest - 1] + ys[widest]) / 2;
    const auto xs = crossings(ring, y, scale);
    Point inner{0, y};
    double width = -1;
    for (std::size_t i = 0; i + 1 < xs.size(); i += 2) {
        if (xs[i + 1] - xs[i] <= width) continue;
        width = xs[i + 1] - xs[i];
        inner.x = (xs[i] + xs[i + 1]) / 2;
    }
    return inner;
}

/// Outer rings of a shape. Their edges are sorted by their lower ends, and the upper ends are stored as maxima of
/// blocks of edges, whose size doubles from level to level. So the edges that cross a horizontal line are found without
/// a visit to all edges.
class OuterRings {
public:
    /// @param outers  indices of the outer rings
    /// @param areas   [rings] areas that the rings enclose
    OuterRings(std::span<const Ring> rings, std::span<const std::size_t> outers, std::span<const double> areas,
               double scale)
        : areas_(areas) {
        for (const std::size_t ring : outers) {
            const Ring& corners = rings[ring];
            for (std::size_t i = 0; i < corners.size(); ++i) {
                const Point a = scale * corners[i], b = scale * corners[(i + 1) % corners.size()];
                if (a.y != b.y) edges_.push_back({a.y < b.y ? a : b, a.y < b.y ? b : a, ring});
            }
        }
        std::ranges::sort(edges_, {}, [](const Edge& edge) { return edge.low.y; });
        std::vector<double> tops;
        for (const Edge& edge : edges_) tops.push_back(edge.high.y);
        while (tops.size() > 1) {
            std::vector<double> next;
            for (std::size_t i = 0; i < tops.size(); i += 2)
                next.push_back(std::max(tops[i], tops[std::min(i + 1, tops.size() - 1)]));
            tops_.push_back(std::exchange(tops, std::move(next)));
        }
        tops_.push_back(std::move(tops));
    }

    /// Finds the smallest outer ring that contains a point and has at least a given area.
    std::optional<std::size_t> find(Point p, double area) {
        constexpr double kLess = 1 - 1e-9;  // for the rounding errors of areas
        crossed_.clear();
        if (!edges_.empty()) collect(tops_.size() - 1, 0, p);
        std::ranges::sort(crossed_);
        std::optional<std::size_t> smallest;
        for (auto i = crossed_.begin(); i != crossed_.end();) {
            const auto end = std::ranges::find_if(i, crossed_.end(), [&](std::size_t ring) { return ring != *i; });
            const bool is_inside = (end - i) % 2 == 1;
            if (is_inside && areas_[*i] >= kLess * area && (!smallest || areas_[*i] < areas_[*smallest])) smallest = *i;
            i = end;
        }
        return smallest;
    }

private:
    /// Collects the rings of the edges in a block that pass a point on its left, one entry for each edge.
    void collect(std::size_t level, std::size_t block, Point p) {
        const std::size_t first = block << level;
        if (block >= tops_[level].size() || tops_[level][block] <= p.y || edges_[first].low.y > p.y) return;
        if (level == 0) {
            if (edges_[first].is_left_of(p)) crossed_.push_back(edges_[first].ring);
            return;
        }
        collect(level - 1, 2 * block, p);
        collect(level - 1, 2 * block + 1, p);
    }

    std::span<const double> areas_;
    std::vector<Edge> edges_;
    std::vector<std::vector<double>> tops_;  ///< [levels][blocks] maximum ordinate of the edges in each block
    std::vector<std::size_t> crossed_;
};

/// Computes twice the area of a ring, which is positive for counter-clockwise rings.
double doubled_area(const Ring& ring, double scale) {
    double sum = 0;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        const Point first = scale * ring[0];
        sum += cross(scale * ring[i - 1] - first, scale * ring[i] - first);
    }
    return sum;
}

}  // namespace

std::vector<std::vector<std::size_t>> group_rings(std::span<const Ring> rings) {
    std::vector<std::size_t> owners(rings.size());
    std::vector<std::size_t> outers;
    std::vector<std::size_t> holes;
    std::vector<double> areas(rings.size());
    const double scale = scale_of(rings);
    for (std::size_t i = 0; i < rings.size(); ++i) {
        owners[i] = i;
        const double doubled = doubled_area(rings[i], scale);
        areas[i] = std::abs(doubled);
        (doubled > 0 ? holes : outers).push_back(i);
    }
    OuterRings index(rings, outers, areas, scale);
    for (const std::size_t hole : holes)
        owners[hole] = index.find(inner_point(rings[hole], scale), areas[hole]).value_or(hole);

    std::vector<std::vector<std::size_t>> polygons;
    std::vector<std::size_t> polygon_of(rings.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
        if (owners[i] != i) continue;
        polygon_of[i] = polygons.size();
        polygons.push_back({i});
    }
    for (const std::size_t hole : holes) {
        if (owners[hole] != hole) polygons[polygon_of[owners[hole]]].push_back(hole);
    }
    return polygons;
}

}  // namespace ccdt::api

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/ring_reduction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>

namespace ccdt {

namespace {

/// The replacement of an edge by a point.
struct Collapse {
    double displacement;
    Point position;
};

/// Returns the area of each of the two equal parts that lie on different sides of the segment `from`-`to`, between this
/// segment and a chain from `from` to `to` along the line through `first` and `second`.
double displaced(Point from, Point to, Point first, Point second) {
    const Point way = to - from, edge = second - first;
    const double slope = cross(way, edge);
    if (slope == 0) return std::abs(cross(first - from, edge));
    const Point meeting = from + cross(first - from, edge) / slope * way;
    return std::abs(cross(first - meeting, from - meeting));
}

/// Finds the point that replaces the edge b-c between the corners a and d, such that the area stays the same.
Collapse collapse(Point a, Point b, Point c, Point d) {
    const Point base = d - a;
    const double area = cross(b - a, c - a) + cross(c - a, base);
    const double left = cross(b - a, base), right = cross(c - a, base);
    const bool same_side = (left > 0) == (right > 0);
    const bool along_first = same_side ? std::abs(left) >= std::abs(right) : (left > 0) == (area > 0);
    const double height = along_first ? left : right;
    if (height == 0) return {std::numeric_limits<double>::infinity(), b};
    if (along_first) {
        const Point position = a + area / height * (b - a);
        return {displaced(d, position, c, b), position};
    }
    const Point position = d + area / height * (c - d);
    return {displaced(a, position, b, c), position};
}

class RingReduction {
public:
    RingReduction(const std::vector<Point>& ring, double displacement, const Box& box)
        : points_(ring), box_(box), left_(ring.size()) {
        const auto count = static_cast<std::uint32_t>(ring.size());
        double twice = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            links_.push_back({(i + count - 1) % count, (i + 1) % count, 0});
            twice += cross(ring[i], ring[(i + 1) % count]);
        }
        const double area = std::abs(twice) / 2;
        most_ = std::min(displacement, kShare * area);
        is_speck_ = area < kSpeck * displacement;
        for (std::uint32_t i = 0; i < count; ++i) consider(i);
    }

    std::vector<Point> reduce() {
        constexpr std::size_t kMin = 4;
        if (is_speck_) return {};
        while (!edges_.empty() && left_ > kMin) {
            const Edge edge = edges_.top();
            edges_.pop();
            if (edge.version != links_[edge.first].version) continue;
            replace(edge.first, edge.position);
        }
        std::vector<Point> result;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            if (links_[i].version != kGone) result.push_back(points_[i]);
        }
        return result;
    }

private:
    static constexpr double kShare = 0.1;   // of the area of the ring
    static constexpr double kSpeck = 0.01;  // of the displacement
    static constexpr std::uint32_t kGone = ~std::uint32_t{0};

    /// A corner's neighbours, and the number of changes of the edge that begins at it.
    struct Links {
        std::uint32_t before, after, version;
    };

    struct Edge {
        double displacement;
        std::uint32_t first, version;
        Point position;

        bool operator<(const Edge& other) const {
            return displacement != other.displacement ? displacement > other.displacement : first > other.first;
        }
    };

    bool is_fixed(std::uint32_t i) const {
        const Point p = points_[i];
        return p.x <= box_.min.x || p.y <= box_.min.y || p.x >= box_.max.x || p.y >= box_.max.y;
    }

    void consider(std::uint32_t first) {
        const auto [before, second, version] = links_[first];
        if (is_fixed(first) || is_fixed(second)) return;
        const auto [displacement, position] =
            collapse(points_[before], points_[first], points_[second], points_[links_[second].after]);
        if (displacement <= most_) edges_.push({displacement, first, version, position});
    }

    void replace(std::uint32_t first, Point position) {
        const std::uint32_t second = links_[first].after, after = links_[second].after;
        points_[first] = position;
        links_[first].after = after;
        links_[after].before = first;
        links_[second].version = kGone;
        --left_;
        std::uint32_t edge = links_[links_[first].before].before;
        for (int i = 0; i < 4; ++i, edge = links_[edge].after) {
            ++links_[edge].version;
            consider(edge);
        }
    }

    std::vector<Point> points_;
    std::vector<Links> links_;
    std::priority_queue<Edge> edges_;
    double most_ = 0;  ///< displacement
    bool is_speck_ = false;
    Box box_;
    std::size_t left_;
};

}  // namespace

std::vector<Point> reduced_ring(const std::vector<Point>& ring, double displacement, const Box& box) {
    return RingReduction(ring, displacement, box).reduce();
}

}  // namespace ccdt

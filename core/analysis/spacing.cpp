// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/analysis/spacing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace ccdt {
namespace {

/// A k-d tree in one array. The middle element of each range splits the range along its longer axis.
class Tree {
public:
    Tree(std::span<const Point> points, Point sides, bool periodic) : sides_(sides), periodic_(periodic) {
        for (const Point& p : points) nodes_.push_back({p, false});
        build(0, nodes_.size());
    }

    std::size_t size() const { return nodes_.size(); }

    /// Returns the distance from a point to its nearest neighbour.
    double nearest_distance(std::size_t index) const {
        Query query{nodes_[index].point, index, std::numeric_limits<double>::infinity()};
        search(0, nodes_.size(), query);
        if (periodic_) search_around(query);
        return std::sqrt(query.best);
    }

private:
    struct Node {
        Point point;
        bool by_y;  ///< whether the element splits the range along y
    };

    struct Query {
        Point from;
        std::size_t self;
        double best;  ///< squared distance of the nearest point found so far
    };

    static double along(Point p, bool by_y) { return by_y ? p.y : p.x; }

    void build(std::size_t begin, std::size_t end) {
        if (end - begin < 2) return;
        const auto first = nodes_.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = nodes_.begin() + static_cast<std::ptrdiff_t>(end);
        const auto extent = [&](bool by_y) {
            const auto [low, high] = std::minmax_element(
                first, last, [&](const Node& a, const Node& b) { return along(a.point, by_y) < along(b.point, by_y); });
            return along(high->point, by_y) - along(low->point, by_y);
        };
        const bool by_y = extent(true) > extent(false);
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(first, nodes_.begin() + static_cast<std::ptrdiff_t>(middle), last,
                         [&](const Node& a, const Node& b) { return along(a.point, by_y) < along(b.point, by_y); });
        nodes_[middle].by_y = by_y;
        build(begin, middle);
        build(middle + 1, end);
    }

    void search(std::size_t begin, std::size_t end, Query& query) const {
        if (begin == end) return;
        const std::size_t middle = begin + (end - begin) / 2;
        const Node& node = nodes_[middle];
        const Point apart = query.from - node.point;
        if (middle != query.self) query.best = std::min(query.best, dot(apart, apart));
        const double ahead = along(apart, node.by_y);
        const std::pair below{begin, middle}, above{middle + 1, end};
        const auto [near_begin, near_end] = ahead < 0 ? below : above;
        search(near_begin, near_end, query);
        if (ahead * ahead >= query.best) return;
        const auto [far_begin, far_end] = ahead < 0 ? above : below;
        search(far_begin, far_end, query);
    }

    /// Searches from the periodic copies of the point.
    void search_around(Query& query) const {
        const Point home = query.from;
        for (const double right : {-1, 0, 1}) {
            for (const double up : {-1, 0, 1}) {
                if (right == 0 && up == 0) continue;
                query.from = home + Point{right * sides_.x, up * sides_.y};
                const Point inside{std::clamp(query.from.x, 0.0, sides_.x), std::clamp(query.from.y, 0.0, sides_.y)};
                const Point apart = query.from - inside;
                if (dot(apart, apart) < query.best) search(0, nodes_.size(), query);
            }
        }
    }

    Point sides_;
    bool periodic_;
    std::vector<Node> nodes_;
};

}  // namespace

Spacing measure_spacing(std::span<const Point> points, Point sides, bool periodic, const std::stop_token& stop) {
    const Tree tree(points, sides, periodic);
    Spacing spacing{std::numeric_limits<double>::infinity(), 0};
    for (std::size_t i = 0; i < tree.size() && !stop.stop_requested(); ++i) {
        const double distance = tree.nearest_distance(i);
        spacing.min = std::min(spacing.min, distance);
        spacing.mean += distance;
    }
    spacing.mean /= static_cast<double>(tree.size());
    return spacing;
}

}  // namespace ccdt

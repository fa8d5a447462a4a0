// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/spacing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/axes.h"

namespace ccdt {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// A point of a surface, with the normal there.
struct Oriented {
    Point3 point;
    Point3 normal;
};
double along(const Oriented& p, std::size_t axis) {
    return along(p.point, axis);
}

/// Returns the squared distance of two points; infinite if they are not neighbours.
template <class P>
double squared_distance(const P& a, const P& b) {
    const P apart = a - b;
    return dot(apart, apart);
}
double squared_distance(const Oriented& a, const Oriented& b) {
    const Point3 apart = a.point - b.point;
    return dot(a.normal, b.normal) < 0 ? kFar : dot(apart, apart);
}

/// A k-d tree in one array. The middle element of each range splits the range along its longest axis.
template <class Site, std::size_t kCount>
class Tree {
public:
    explicit Tree(std::size_t size) { nodes_.reserve(size); }

    void add(const Site& site) { nodes_.push_back({site, static_cast<std::uint32_t>(nodes_.size()), 0}); }
    void build() { build(0, nodes_.size()); }

    std::size_t size() const { return nodes_.size(); }
    const Site& site(std::size_t index) const { return nodes_[index].site; }

    /// Returns the smaller one of `best` and the squared distance from a site to the nearest site other than `self`.
    double nearest(const Site& from, std::size_t self, double best) const {
        Query query{from, self, best};
        search(0, nodes_.size(), query);
        return query.best;
    }

private:
    struct Node {
        Site site;
        std::uint32_t number;  ///< in the order of calls of add()
        std::uint32_t axis;    ///< axis along which the element splits the range
    };

    struct Query {
        const Site& from;
        std::size_t self;
        double best;  ///< squared distance of the nearest site found so far
    };

    void build(std::size_t begin, std::size_t end) {
        if (end - begin < 2) return;
        const auto first = nodes_.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = nodes_.begin() + static_cast<std::ptrdiff_t>(end);
        std::array<double, kCount> extents{};
        for (std::size_t axis = 0; axis < kCount; ++axis) {
            const auto [low, high] = std::minmax_element(first, last, [axis](const Node& a, const Node& b) {
                return along(a.site, axis) < along(b.site, axis);
            });
            extents[axis] = along(high->site, axis) - along(low->site, axis);
        }
        const auto axis = static_cast<std::uint32_t>(std::ranges::max_element(extents) - extents.begin());
        const std::size_t middle = begin + (end - begin) / 2;
        // A total order determines the tree, and so the order of summation, for every standard library.
        std::nth_element(first, nodes_.begin() + static_cast<std::ptrdiff_t>(middle), last,
                         [axis](const Node& a, const Node& b) {
                             const double x = along(a.site, axis), y = along(b.site, axis);
                             return x < y || (x == y && a.number > b.number);
                         });
        nodes_[middle].axis = axis;
        build(begin, middle);
        build(middle + 1, end);
    }

    void search(std::size_t begin, std::size_t end, Query& query) const {
        if (begin == end) return;
        const std::size_t middle = begin + (end - begin) / 2;
        const Node& node = nodes_[middle];
        if (middle != query.self) query.best = std::min(query.best, squared_distance(query.from, node.site));
        const double ahead = along(query.from, node.axis) - along(node.site, node.axis);
        const std::pair below{begin, middle}, above{middle + 1, end};
        const auto [near_begin, near_end] = ahead < 0 ? below : above;
        search(near_begin, near_end, query);
        if (ahead * ahead >= query.best) return;
        const auto [far_begin, far_end] = ahead < 0 ? above : below;
        search(far_begin, far_end, query);
    }

    std::vector<Node> nodes_;
};

/// Searches from the periodic copies of a site. Returns the squared distance of the nearest neighbour, at most `best`.
template <class P>
double search_around(const Tree<P, kAxes<P>>& tree, std::size_t index, const P& sides, double best) {
    constexpr int kCopies = kAxes<P> == 2 ? 9 : 27, kOriginal = kCopies / 2;
    for (int number = 0; number < kCopies; ++number) {
        if (number == kOriginal) continue;
        P copy = tree.site(index), inside = copy;
        for (std::size_t axis = kAxes<P>, rest = static_cast<std::size_t>(number); axis-- > 0; rest /= 3) {
            along(copy, axis) += (static_cast<double>(rest % 3) - 1) * along(sides, axis);
            along(inside, axis) = std::clamp(along(copy, axis), 0.0, along(sides, axis));
        }
        if (squared_distance(copy, inside) < best) best = tree.nearest(copy, index, best);
    }
    return best;
}

/// Returns the least and the mean distance of the points that have a neighbour.
/// @param nearest  function from the number of a point to the squared distance of its nearest neighbour
/// @param weight   function from the number of a point and the distance to the weight in the mean
template <class Nearest, class Weight>
Spacing summarise(std::size_t count, const std::stop_token& stop, Nearest&& nearest, Weight&& weight) {
    Spacing spacing{kFar, 0};
    double weights = 0, weighted = 0, sum = 0;
    std::size_t with_neighbour = 0;
    for (std::size_t i = 0; i < count && !stop.stop_requested(); ++i) {
        const double distance = std::sqrt(nearest(i));
        if (distance == kFar) continue;
        ++with_neighbour;
        spacing.min = std::min(spacing.min, distance);
        sum += distance;
        const double share = weight(i, distance);
        weights += share;
        weighted += share * distance;
    }
    spacing.mean = with_neighbour > 0 ? sum / static_cast<double>(with_neighbour) : kFar;
    if (weights > 0) spacing.mean = weighted / weights;
    return spacing;
}

/// The weight of each distance if no distance is weighted.
template <class Site>
double unweighted(const Site&, double) {
    return 0;
}

template <class P, class Weigh>
Spacing measure(std::span<const P> points, const P& sides, bool periodic, const std::stop_token& stop, Weigh&& weigh) {
    Tree<P, kAxes<P>> tree(points.size());
    for (const P& p : points) tree.add(p);
    tree.build();
    return summarise(
        tree.size(), stop,
        [&](std::size_t i) {
            const double best = tree.nearest(tree.site(i), i, kFar);
            return periodic ? search_around(tree, i, sides, best) : best;
        },
        [&](std::size_t i, double distance) { return weigh(tree.site(i), distance); });
}

}  // namespace

Spacing measure_spacing(std::span<const Point> points, Point sides, bool periodic, const std::stop_token& stop,
                        const WeighDistance& weigh) {
    if (weigh) return measure(points, sides, periodic, stop, weigh);
    return measure(points, sides, periodic, stop, unweighted<Point>);
}

Spacing measure_spacing(std::span<const Point3> points, Point3 sides, bool periodic, const std::stop_token& stop) {
    return measure(points, sides, periodic, stop, unweighted<Point3>);
}

Spacing measure_spacing(std::span<const Point3> points, std::span<const Point3> normals, const std::stop_token& stop) {
    Tree<Oriented, 3> tree(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) tree.add({points[i], normals[i]});
    tree.build();
    return summarise(
        tree.size(), stop, [&](std::size_t i) { return tree.nearest(tree.site(i), i, kFar); }, unweighted<std::size_t>);
}

}  // namespace ccdt

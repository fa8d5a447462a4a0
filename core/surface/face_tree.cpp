// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/face_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint32_t kLeafSize = 4;  ///< largest number of triangles in a node without children

double squared(Point3 p) {
    return dot(p, p);
}

/// Returns the barycentric coordinates of the point of a triangle that is nearest to p.
std::array<double, 3> nearest_weights(Point3 p, const std::array<Point3, 3>& triangle) {
    const Point3 u = triangle[1] - triangle[0], v = triangle[2] - triangle[0], n = cross(u, v);
    const double length = std::max(squared(u), squared(v)), area = squared(n);
    constexpr double kLeastArea = 1e-12;  // thinner triangles count as their edges, because rounding dominates
    if (area > kLeastArea * length * length) {
        const Point3 from = p - triangle[0], foot = from - dot(from, n) / area * n;
        const double b = dot(n, cross(foot, v)) / area, c = dot(n, cross(u, foot)) / area;
        if (b >= 0 && c >= 0 && b + c <= 1) return {std::max(0.0, 1 - b - c), b, c};
    }
    std::array<double, 3> weights{};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const Point3 from = p - triangle[k], edge = triangle[next] - triangle[k];
        const double t = std::clamp(dot(from, edge) / squared(edge), 0.0, 1.0);
        const double distance = squared(from - t * edge);
        if (distance >= least) continue;
        least = distance;
        weights = {};
        weights[k] = 1 - t;
        weights[next] = t;
    }
    return weights;
}

Point3 least(Point3 a, Point3 b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Point3 most(Point3 a, Point3 b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

FaceTree::FaceTree(std::vector<std::uint32_t> faces, Corners corners)
    : faces_(std::move(faces)), corners_(std::move(corners)) {
    std::vector<Centre> centres(faces_.size());
    std::transform(faces_.begin(), faces_.end(), centres.begin(), [this](std::uint32_t face) {
        const auto [a, b, c] = corners_(face);
        return Centre{a + b + c, face};
    });
    build(centres, {0, static_cast<std::uint32_t>(faces_.size())});
}

/// Adds a node for a range of faces, and sorts the centres of the range by node.
void FaceTree::build(std::span<Centre> centres, Range range) {
    const std::size_t number = nodes_.size();
    nodes_.emplace_back();
    if (range.end - range.begin <= kLeafSize) {
        for (std::uint32_t i = range.begin; i < range.end; ++i) {
            faces_[i] = centres[i].face;
            for (const Point3& p : corners_(faces_[i])) nodes_[number].include(p, p);
        }
        return;
    }
    Node spread;
    for (const Centre& centre : centres.subspan(range.begin, range.end - range.begin)) {
        spread.include(centre.place, centre.place);
    }
    const Point3 size = spread.max - spread.min;
    const auto axis = size.x >= std::max(size.y, size.z) ? &Point3::x : size.y >= size.z ? &Point3::y : &Point3::z;
    std::nth_element(centres.begin() + range.begin, centres.begin() + range.middle(), centres.begin() + range.end,
                     [axis](const Centre& a, const Centre& b) {
                         const double first = a.place.*axis, second = b.place.*axis;
                         return first != second ? first < second : a.face < b.face;
                     });
    build(centres, {range.begin, range.middle()});
    const std::size_t second = nodes_.size();
    nodes_[number].second = static_cast<std::uint32_t>(second);
    build(centres, {range.middle(), range.end});
    nodes_[number].include(nodes_[number + 1].min, nodes_[number + 1].max);
    nodes_[number].include(nodes_[second].min, nodes_[second].max);
}

void FaceTree::Node::include(Point3 from, Point3 to) {
    min = least(min, from);
    max = most(max, to);
}

FaceTree::Nearest FaceTree::nearest(Point3 p) const {
    Nearest found{.squared = kInfinity};
    search(0, {0, static_cast<std::uint32_t>(faces_.size())}, p, found);
    return found;
}

/// Searches a node for a point that is nearer than the one found.
void FaceTree::search(std::uint32_t number, Range range, Point3 p, Nearest& found) const {
    const std::uint32_t second = nodes_[number].second;
    if (second == 0) {
        for (std::uint32_t i = range.begin; i < range.end; ++i) {
            const auto triangle = corners_(faces_[i]);
            const auto weights = nearest_weights(p, triangle);
            const double distance =
                squared(weights[0] * triangle[0] + weights[1] * triangle[1] + weights[2] * triangle[2] - p);
            if (distance < found.squared) found = {faces_[i], weights, distance};
        }
        return;
    }
    const auto distance = [this, p](std::uint32_t child) {
        const Node& node = nodes_[child];
        return squared(most(node.min, least(p, node.max)) - p);
    };
    const double to_first = distance(number + 1), to_second = distance(second);
    const auto search_first = [&] {
        if (to_first < found.squared) search(number + 1, {range.begin, range.middle()}, p, found);
    };
    if (to_first <= to_second) search_first();
    if (to_second < found.squared) search(second, {range.middle(), range.end}, p, found);
    if (to_first > to_second) search_first();
}

}  // namespace ccdt

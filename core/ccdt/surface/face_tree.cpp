// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/face_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/axes.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kLeafSize = 4;  ///< largest number of triangles in a node without children
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double squared(Point3 p) {
    return dot(p, p);
}

/// Returns orthogonal axes: along the longest edge of a triangle, across it, and along the normal.
std::array<Point3, 3> axes_of(const std::array<Point3, 3>& triangle) {
    const auto edge = [&](std::size_t k) { return triangle[(k + 1) % 3] - triangle[k]; };
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        if (squared(edge(k)) > squared(edge(longest))) longest = k;
    }
    const auto unit = [](Point3 p) { return 1 / length(p) * p; };
    const Point3 axis = unit(edge(longest));
    const auto across = [axis](Point3 p) { return p - dot(p, axis) * axis; };
    constexpr double kMin = 1e-6;  // rounding would turn shorter vectors
    Point3 side = across(unit(edge((longest + 1) % 3)));
    if (length(side) < kMin) side = across(std::abs(axis.x) < 0.5 ? Point3{1, 0, 0} : Point3{0, 1, 0});
    side = unit(side);
    return {axis, side, cross(axis, side)};
}

}  // namespace

std::array<double, 3> nearest_weights(Point3 p, const std::array<Point3, 3>& triangle) {
    const Point3 u = triangle[1] - triangle[0], v = triangle[2] - triangle[0], n = cross(u, v);
    const double length = std::max(squared(u), squared(v)), area = squared(n);
    constexpr double kMinArea = 1e-12;  // thinner triangles count as their edges, because rounding dominates
    if (area > kMinArea * length * length) {
        const Point3 from = p - triangle[0], foot = from - dot(from, n) / area * n;
        const double b = dot(n, cross(foot, v)) / area, c = dot(n, cross(u, foot)) / area;
        if (b >= 0 && c >= 0 && b + c <= 1) return {std::max(0.0, 1 - b - c), b, c};
    }
    std::array<double, 3> weights{};
    double least = kInfinity;
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

Point3 FaceTree::Node::along_axes(Point3 p) const {
    const auto coordinate = [p](const auto& axis) { return axis[0] * p.x + axis[1] * p.y + axis[2] * p.z; };
    return {coordinate(axes[0]), coordinate(axes[1]), coordinate(axes[2])};
}

double FaceTree::Node::squared_distance(Point3 p) const {
    double sum = 0;
    const Point3 local = along_axes(p);
    for (std::size_t k = 0; k < 3; ++k) {
        const double at = along(local, k), beyond = std::max({min[k] - at, at - max[k], 0.0});
        sum += beyond * beyond;
    }
    return sum;
}

bool FaceTree::Node::is_on_ray(Point3 p) const {
    constexpr double kRounding = 1e-9;  // more than the errors of coordinates along the axes, which are at most 2
    const Point3 local = along_axes(p);
    double from = 0, to = kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
        const double rate = static_cast<double>(axes[k][0]);  // per step along x
        const double low = min[k] - kRounding - along(local, k), high = max[k] + kRounding - along(local, k);
        if (rate == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        from = std::max(from, std::min(low / rate, high / rate));
        to = std::min(to, std::max(low / rate, high / rate));
    }
    return from <= to;
}

FaceTree::FaceTree(std::span<const Point3> vertices, std::vector<Face> faces) : vertices_(vertices) {
    std::vector<Item> items(faces.size());
    std::ranges::transform(faces, items.begin(), [this](const Face& face) {
        const auto [a, b, c] = positions(face);
        const Box3 box = bounds_of(std::array{a, b, c});
        return Item{box.min + box.max, std::max({squared(b - a), squared(c - b), squared(a - c)}), face};
    });
    faces_.reserve(faces.size());
    build(items);
}

FaceTree::Node FaceTree::box_around(std::span<const Item> items) const {
    constexpr double kShare = 1 - 1e-6;  // so that distances along rounded axes are not too long
    const auto axes = axes_of(positions(std::ranges::max_element(items, {}, &Item::longest)->face));
    Node node;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 3; ++i) node.axes[k][i] = static_cast<float>(kShare * along(axes[k], i));
    }
    const Point3 first = node.along_axes(vertices_[items.front().face.corners[0]]);
    Box3 box{first, first};
    for (const Item& item : items) {
        for (const std::uint32_t corner : item.face.corners)
            box = bounds_of(std::array{box.min, box.max, node.along_axes(vertices_[corner])});
    }
    for (std::size_t k = 0; k < 3; ++k) {
        node.min[k] = std::nextafter(static_cast<float>(along(box.min, k)), -2.0F);
        node.max[k] = std::nextafter(static_cast<float>(along(box.max, k)), 2.0F);
    }
    return node;
}

/// Adds a node for a range of faces, and sorts them by node.
void FaceTree::build(std::span<Item> items) {
    const std::size_t number = nodes_.size();
    nodes_.push_back(box_around(items));
    if (items.size() <= kLeafSize) {
        // nth_element() leaves faces in an order that depends on the standard library.
        std::ranges::sort(items, {}, [](const Item& item) { return item.face.number; });
        for (const Item& item : items) faces_.push_back(item.face);
        return;
    }
    Box3 box{items[0].centre, items[0].centre};
    for (const Item& item : items) box = bounds_of(std::array{box.min, box.max, item.centre});
    const Point3 size = box.max - box.min;
    const std::size_t axis = size.x >= std::max(size.y, size.z) ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t middle = items.size() / 2;
    std::ranges::nth_element(items, items.begin() + static_cast<std::ptrdiff_t>(middle), {}, [axis](const Item& item) {
        return std::pair(along(item.centre, axis), item.face.number);
    });
    build(items.first(middle));
    nodes_[number].second = static_cast<std::uint32_t>(nodes_.size());
    build(items.subspan(middle));
}

std::optional<FaceTree::Nearest> FaceTree::nearest(Point3 p, double within) const {
    Nearest found{.face = ~0U, .squared = within * within};
    search(0, {0, static_cast<std::uint32_t>(faces_.size())}, p, found);
    if (found.face == ~0U) return std::nullopt;
    return found;
}

/// Searches a node for a point that is nearer than the one found.
void FaceTree::search(std::uint32_t number, Range range, Point3 p, Nearest& found) const {
    const std::uint32_t second = nodes_[number].second;
    if (second == 0) {
        for (std::uint32_t i = range.begin; i < range.end; ++i) {
            if (faces_[i].is_flat) continue;
            const auto triangle = positions(faces_[i]);
            const auto weights = nearest_weights(p, triangle);
            const double distance =
                squared(weights[0] * triangle[0] + weights[1] * triangle[1] + weights[2] * triangle[2] - p);
            if (distance < found.squared) found = {faces_[i].number, weights, distance};
        }
        return;
    }
    const double to_first = nodes_[number + 1].squared_distance(p), to_second = nodes_[second].squared_distance(p);
    const auto search_first = [&] {
        if (to_first < found.squared) search(number + 1, {range.begin, range.middle()}, p, found);
    };
    if (to_first <= to_second) search_first();
    if (to_second < found.squared) search(second, {range.middle(), range.end}, p, found);
    if (to_first > to_second) search_first();
}

}  // namespace ccdt

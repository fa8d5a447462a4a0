// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/face_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace ccdt {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;

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

Kernel::Point_3 to_cgal(Point3 p) {
    return {p.x, p.y, p.z};
}

/// A triangle of a tree, which holds only its number: CGAL's concept AABBPrimitiveWithSharedData.
class Primitive {
public:
    using Id = std::uint32_t;
    using Point = Kernel::Point_3;
    using Datum = Kernel::Triangle_3;
    using Datum_reference = Datum;
    using Point_reference = Point;
    using Shared_data = const FaceTree::Corners*;

    Primitive(std::span<const Id>::iterator face, Shared_data) : face_(*face) {}

    static Shared_data construct_shared_data(Shared_data corners) { return corners; }
    Id id() const { return face_; }
    Datum datum(Shared_data corners) const {
        const auto [a, b, c] = (*corners)(face_);
        return {to_cgal(a), to_cgal(b), to_cgal(c)};
    }
    Point reference_point(Shared_data corners) const {
        const auto [a, b, c] = (*corners)(face_);
        return to_cgal(1. / 3 * (a + b + c));
    }

private:
    Id face_;
};

}  // namespace

struct FaceTree::Tree {
    Tree(std::span<const std::uint32_t> faces, Corners function)
        : corners(std::move(function)), boxes(faces.begin(), faces.end(), &corners) {
        boxes.build();
        boxes.accelerate_distance_queries();  // otherwise, the first query would do it
    }

    Corners corners;
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> boxes;
};

FaceTree::FaceTree(std::span<const std::uint32_t> faces, Corners corners)
    : tree_(std::make_unique<Tree>(faces, std::move(corners))) {}

FaceTree::~FaceTree() = default;

FaceTree::Nearest FaceTree::nearest(Point3 p) const {
    const std::uint32_t face = tree_->boxes.closest_point_and_primitive(to_cgal(p)).second;
    return {face, nearest_weights(p, tree_->corners(face))};
}

}  // namespace ccdt
